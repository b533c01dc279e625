"""An image VAE that learns another kind of sensor: all that goes with it, mesh VAE and projections, stays as it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from split_models.learning.augment import Augmentation
from split_models.learning.checkpoint import TrainedOn
from split_models.learning.data import TouchFrames
from split_models.learning.items import Batch, frame_of
from split_models.learning.objectives import ImageVaeObjective
from split_models.learning.train import BEST, train
from split_models.learning.train_options import TrainOptions
from split_models.networks.image_vae import ImageVae
from split_models.networks.latent import decode_pictures, encode_pictures
from split_models.networks.learned_backgrounds import kept_small
from split_models.transfer.latent_transfer import scaled
from tactiledata.contract.progress import Progress
from tactiledata.contract.provenance import digest_of
from tactiledata.metrics.image_similarity import IMAGE_SIMILARITY

AUGMENTATION = Augmentation(noise=0.02, contrast=0.05, brightness=0.05)
"""Pictures are neither mirrored nor turned: their light is what is learned."""
DIVERGENCE_WEIGHT = 0.001
BACKGROUND_COPIES = 16
"""How often a sensor's picture without contact is among the items, as in the recipes."""


@dataclass(frozen=True)
class FineTuned:
    """What came of it.

    Parameters
    ----------
    checkpoint : Path
        Of an image VAE, as `--model` takes it.
    pictures : int
        Learned from.
    before, after : float
        Mean difference of the decoded validation pictures to the recorded ones, grey levels.
    """

    checkpoint: Path
    pictures: int
    before: float
    after: float


class SizedPictures:
    """``image`` (n, h, w, 3), uint8: a part's pictures at a VAE's size, then its sensors' backgrounds."""

    def __init__(self, frames: TouchFrames, size: tuple[int, int], background_copies: int = 0) -> None:
        self.frames, self.size = frames, size
        self._names = [name for name in frames.sensor_names for _ in range(background_copies)]

    @property
    def fingerprint(self) -> str:
        """The same for the same pictures."""
        return digest_of([self.frames.fingerprint, list(self.size), self._names])

    def __len__(self) -> int:
        return len(self.frames) + len(self._names)

    def batch(self, numbers: Sequence[int]) -> Batch:
        """``image``."""
        pictures = np.concatenate([scaled(self._picture(number), self.size) for number in numbers])
        return {"image": torch.from_numpy(np.ascontiguousarray(pictures))}

    def where(self, number: int) -> str:
        """Store and frame."""
        if number < len(self.frames):
            return frame_of(self.frames, number)
        return f"the background of {self._names[number - len(self.frames)]}"

    def _picture(self, number: int) -> np.ndarray:
        if number < len(self.frames):
            return self.frames.pictures([number])
        return self.frames.background(self._names[number - len(self.frames)])[None]


def fine_tune(
    vae: ImageVae,
    parent: str,
    train_frames: TouchFrames,
    validation: TouchFrames,
    options: TrainOptions,
    folder: Path,
    tell: Progress | None = None,
) -> FineTuned:
    """The VAE trained further on another sensor's pictures; killed and called again it goes on.

    Parameters
    ----------
    vae : ImageVae
        Learns in place.
    parent : str
        SHA-256 of the checkpoint that it is from.
    train_frames, validation : TouchFrames
        At their own size; pictures that lie are turned upright for a VAE of upright ones.
    options : TrainOptions
    folder : Path
        Checkpoints and the curve go there.
    tell : callable, optional

    Raises
    ------
    CheckpointError
        The folder holds a training of other pictures, options or parent.
    """
    items = SizedPictures(train_frames, vae.size, BACKGROUND_COPIES)
    held = SizedPictures(validation, vae.size)
    before = reconstruction_error(vae, held)
    recipe = digest_of({"fine-tuned from": parent, "augmentation": vars(AUGMENTATION), "options": vars(options)})
    stamps = TrainedOn(recipe, train_frames.split_digest, digest_of([items.fingerprint, held.fingerprint]), "")
    if vae.learned_from:  # of a parent that does not say, nobody knows all
        vae.learned_from += kept_small(list(train_frames.backgrounds().items()))
    objective = ImageVaeObjective(vae, DIVERGENCE_WEIGHT, 0, AUGMENTATION)
    train(objective, items, held, options, folder, stamps, torch.device("cpu"), tell=tell)
    return FineTuned(folder / BEST, len(train_frames), before, reconstruction_error(vae, held))


def reconstruction_error(vae: ImageVae, items: SizedPictures) -> float:
    """Mean difference, grey levels, of what the VAE makes of pictures to these."""
    true = items.batch(range(len(items)))["image"].numpy()
    return float(IMAGE_SIMILARITY.scores["l1"](decode_pictures(vae, encode_pictures(vae, true)), true).mean())
