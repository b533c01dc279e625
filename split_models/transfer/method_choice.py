"""The transfer method that is used where none is named, and what a method keeps of a store's own touches.

An image VAE is asked to draw the store's own touches first. Where it does, latent arithmetic has a part in the
transfer; where it does not, the touch goes as it was recorded, in the target's light.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from split_models.transfer.methods import BUNDLED_MODEL, TransferMethod, model_file, transfer_method, vae_transfer
from split_models.transfer.picture_size import scaled
from tactiledata.arrays import PictureArray
from tactiledata.scoring.kept_touches import LEAST_KEPT, KeptTouch, kept_touch
from tactiledata.scoring.sensor_sets import load_pictures, sensor_sets
from tactiledata.store.read.reader import Store

if TYPE_CHECKING:
    from split_models.networks.image_vae import ImageVae

KEEPING = "relit"
"""The method that keeps touches whatever a model has learned."""
LEARNED = "latent_relit"
"""The method where the model draws the store's own touches."""
DRAWING = "latent_on_background"
"""The method that a model's own part is measured by: from a sensor to itself it is encoding and decoding alone."""
FRAMES = 24
"""Largest number of frames of each sensor that are measured."""


@dataclass(frozen=True)
class TouchSample:
    """Some recorded touches of one sensor.

    Parameters
    ----------
    sensor : str
        Name of the sensor.
    pictures : (n, H, W, 3) uint8
        Pictures of touches.
    background : (H, W, 3) uint8
        The sensor without contact.
    """

    sensor: str
    pictures: PictureArray
    background: PictureArray


@dataclass(frozen=True)
class MethodChoice:
    """A transfer method, and why it is used.

    Parameters
    ----------
    method : TransferMethod
        The method.
    drawn : tuple of KeptTouch
        How much of each sensor's own touches the model draws; empty where no model was measured.
    reason : str
        A sentence for the user; empty where the method was named.
    """

    method: TransferMethod
    drawn: tuple[KeptTouch, ...] = ()
    reason: str = ""


def touch_samples(store: Store, sensors: Sequence[str] | None = None) -> list[TouchSample]:
    """Some recorded touches of each sensor that has a picture without contact of its frames' size.

    Parameters
    ----------
    store : Store
        The store of the touches.
    sensors : list of str, optional
        Sensors to look at; all unless given.
    """
    samples = []
    for pictures_of in sensor_sets(store, FRAMES, least=0):
        name = pictures_of.sensor
        if pictures_of.is_derived or name not in store.manifest["references"]:
            continue
        if sensors is not None and name not in sensors:
            continue
        pictures, background = load_pictures(store, pictures_of), store.reference(name).image
        if pictures.shape[1:] == background.shape:
            samples.append(TouchSample(name, pictures, background))
    return samples


def kept_by(method: TransferMethod, samples: Sequence[TouchSample], target: PictureArray) -> tuple[KeptTouch, ...]:
    """How much of some touches a method keeps on a target, sensor by sensor.

    Parameters
    ----------
    method : TransferMethod
        The method.
    samples : list of TouchSample
        Touches, sensor by sensor.
    target : (H, W, 3) uint8
        The target without contact. Where it has another size, recorded touches are scaled to it.
    """
    size = target.shape[:2]
    return tuple(
        kept_touch(
            sample.sensor,
            method.transfer(sample.pictures, sample.background, target),
            target,
            scaled(sample.pictures, size),
            scaled(sample.background[None], size)[0],
        )
        for sample in samples
    )


def choose_method(
    name: str | None, model: Path | None, samples: Sequence[TouchSample], device: str = "cpu"
) -> MethodChoice:
    """The named transfer method, or where none is named the one that suits a store's touches.

    Parameters
    ----------
    name : str, optional
        A method's name. Without one `LEARNED` is chosen where the model draws the touches of every sensor, else
        `KEEPING`.
    model : Path, optional
        Checkpoint of an image VAE; the bundled one unless given.
    samples : list of TouchSample
        Touches of the store.
    device : "cpu" or "cuda"
        Device that the image VAE runs on.

    Raises
    ------
    UnknownName, UsageError, MissingFile, CheckpointError
        As `split_models.transfer.methods.transfer_method`.
    """
    if name is not None:
        method = transfer_method(name, model, device)
        vae = getattr(method, "vae", None)
        return MethodChoice(method, () if vae is None else _drawn(vae, samples))
    keeping = transfer_method(KEEPING)
    if model is None and not BUNDLED_MODEL.is_file():
        return MethodChoice(keeping, (), "no model of pictures is bundled: each touch goes as it was recorded")
    from split_models.transfer.latent_transfer import load_image_vae

    vae, *stamps = load_image_vae(model_file(model, "transfer"), device)
    drawn = _drawn(vae, samples)
    if drawn and all(kept.is_kept for kept in drawn):
        return MethodChoice(vae_transfer(LEARNED, vae, *stamps), drawn, "the model draws the touches of this store")
    poor = ", ".join(kept.sensor for kept in drawn if not kept.is_kept) or "no sensor with a touch to measure"
    reason = (
        f"the model does not draw the touches of this store ({poor}: below {LEAST_KEPT:g}), so each goes as it was "
        "recorded, in the target's light"
    )
    return MethodChoice(keeping, drawn, reason)


def _drawn(vae: ImageVae, samples: Sequence[TouchSample]) -> tuple[KeptTouch, ...]:
    """How much of each sensor's own touches an image VAE draws on the sensor's own background."""
    drawing = vae_transfer(DRAWING, vae)
    return tuple(kept_by(drawing, [sample], sample.background)[0] for sample in samples)


def documents(drawn: Sequence[KeptTouch], kept: Sequence[KeptTouch]) -> dict[str, Any]:
    """Figures of a transfer as values for JSON: what the model draws, and what the method keeps."""
    return {"drawn_by_model": [one.document() for one in drawn], "kept_touch": [one.document() for one in kept]}
