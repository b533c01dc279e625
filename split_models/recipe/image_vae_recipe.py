"""The image beta-VAE and its objective, built from a recipe's section ``image_vae``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from split_models.learning.augment import Augmentation
from split_models.learning.data import TouchFrames
from split_models.learning.held_out_background import refuse_held_out
from split_models.learning.objectives import ImageVaeObjective, Objective
from split_models.learning.relighting import ArithmeticVaeObjective
from split_models.networks.image_vae import ImageVae
from split_models.networks.learned_backgrounds import kept_small
from tactiledata.store.read.targets import find_target

SIZES = ("blocks", "down", "channels", "latent", "activation", "upsampling")
"""Keys of a recipe's section that are arguments of `ImageVae`."""


def image_vae_objective(
    section: Mapping[str, Any], frames: TouchFrames, start: ImageVae | None = None, extra: Sequence[TouchFrames] = ()
) -> Objective:
    """The objective of a recipe's section ``image_vae``: latent arithmetic where it asks for relighting, else plain.

    Parameters
    ----------
    section : dict
        The section, complete.
    frames : TouchFrames
        Frames of the train part.
    start : ImageVae, optional
        Network whose weights training starts from.
    extra : list of TouchFrames
        Pictures of other corpora to learn from.

    Raises
    ------
    UnknownName
        A background has no such name.
    UsageError
        A background is that of a sensor of the store that is held out of the train part.
    """
    assert frames.size is not None  # recipes state it
    # the network, and the sensors that it learns from
    vae = ImageVae(frames.size, **{name: section[name] for name in SIZES})
    if start is not None:
        vae.load_state_dict(start.state_dict())
    own = [(name, background) for part in (frames, *extra) for name, background in part.backgrounds().items()]
    vae.learned_from = kept_small([*(start.learned_from if start is not None else ()), *own])
    # the objective, plain or with relighting
    augmentation = Augmentation(**section["augmentation"])
    relighting = section["relighting"]
    if not any(relighting[name] for name in ("relit", "exchanged", "contact_weight", "gradient_weight")):
        return ImageVaeObjective(vae, section["divergence_weight"], section["anneal"], augmentation)
    others = [(name, _background(name, frames)) for name in relighting["backgrounds"]]
    vae.learned_from += kept_small(others)
    return ArithmeticVaeObjective(
        vae,
        section["divergence_weight"],
        section["anneal"],
        augmentation,
        backgrounds=np.stack([*frames.backgrounds().values(), *(picture for _, picture in others)]),
        relit=relighting["relit"],
        exchanged=relighting["exchanged"],
        contact_weight=relighting["contact_weight"],
        gradient_weight=relighting["gradient_weight"],
    )


def _background(name: str, frames: TouchFrames) -> NDArray[np.uint8]:
    """Background (h, w, 3) of a sensor by name, at the frames' size; those of held-out sensors are refused."""
    store = frames.arrays.store
    assert frames.size is not None
    picture = _sized(find_target(name, store).background, frames.size)
    refuse_held_out(name, picture, store, frames.sensor_names, "Leave it out of `relighting.backgrounds`.")
    return picture


def _sized(picture: NDArray[np.uint8], size: Sequence[int]) -> NDArray[np.uint8]:
    """The picture (h, w, 3) scaled by area to (height, width)."""
    return np.asarray(cv2.resize(picture, (size[1], size[0]), interpolation=cv2.INTER_AREA), np.uint8)
