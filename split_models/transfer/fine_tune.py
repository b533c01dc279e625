"""Fine-tuning of an image VAE on another sensor's pictures; mesh VAE and projections stay as they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from split_models.learning.augment import Augmentation
from split_models.learning.checkpoint import TrainedOn
from split_models.learning.data import TouchFrames
from split_models.learning.device import find_device
from split_models.learning.items import Batch, frame_of
from split_models.learning.objectives import ImageVaeObjective
from split_models.learning.train import BEST, train
from split_models.learning.train_options import TrainOptions
from split_models.networks.image_vae import ImageVae
from split_models.networks.latent import decode_pictures, encode_pictures
from split_models.networks.learned_backgrounds import kept_small
from split_models.transfer.picture_size import scaled
from tactiledata.contract.progress import Progress
from tactiledata.contract.provenance import digest_of
from tactiledata.metrics.image_similarity import IMAGE_SIMILARITY

AUGMENTATION = Augmentation(noise=0.02, contrast=0.05, brightness=0.05)
"""Random changes of pictures; none is mirrored or rotated, because their light is what is learned."""
DIVERGENCE_WEIGHT = 0.001
"""Weight of the divergence in the loss, as in the recipes."""
BACKGROUND_COPIES = 16
"""Number of times that a sensor's picture without contact is among the items, as in the recipes."""


@dataclass(frozen=True)
class FineTuned:
    """Result of a fine-tuning.

    Parameters
    ----------
    checkpoint : Path
        Checkpoint of the image VAE, as `--model` takes it.
    pictures : int
        Number of pictures that were learned from.
    before, after : float
        Mean difference of the decoded validation pictures to the recorded ones, grey levels.
    """

    checkpoint: Path
    pictures: int
    before: float
    after: float

    @property
    def is_worse(self) -> bool:
        """Whether pictures that were not learned from are drawn worse than before."""
        return self.after > self.before


class SizedPictures:
    """Items ``image`` (n, h, w, 3), uint8: a part's pictures at a VAE's size, then backgrounds of its sensors.

    Parameters
    ----------
    frames : TouchFrames
    size : (height, width) px
        Size of the VAE's pictures.
    background_copies : int
        How often each sensor's picture without contact is among the items.
    """

    def __init__(self, frames: TouchFrames, size: tuple[int, int], background_copies: int = 0) -> None:
        self.frames, self.size = frames, size
        self._names = [name for name in frames.sensor_names for _ in range(background_copies)]

    @property
    def fingerprint(self) -> str:
        """Digest of the frames, the size and the backgrounds."""
        return digest_of([self.frames.fingerprint, list(self.size), self._names])

    def __len__(self) -> int:
        return len(self.frames) + len(self._names)

    def batch(self, numbers: Sequence[int]) -> Batch:
        """Tensor ``image`` (n, h, w, 3), uint8, of items by their number."""
        pictures = np.concatenate([scaled(self._picture(number), self.size) for number in numbers])
        return {"image": torch.from_numpy(np.ascontiguousarray(pictures))}

    def where(self, number: int) -> str:
        """Store and frame of an item, or the sensor of a background."""
        if number < len(self.frames):
            return frame_of(self.frames, number)
        return f"the background of {self._names[number - len(self.frames)]}"

    def _picture(self, number: int) -> np.ndarray:
        """Picture (1, H, W, 3) of an item in its own size."""
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
    device: str = "cpu",
    tell: Progress | None = None,
) -> FineTuned:
    """The result of training a VAE further on another sensor's pictures; a killed training is resumed by the same call.

    Parameters
    ----------
    vae : ImageVae
        The network, which is trained in place.
    parent : str
        SHA-256 of the checkpoint that it was read from.
    train_frames, validation : TouchFrames
        Pictures in their own size; pictures in landscape format are rotated for a VAE of upright ones.
    options : TrainOptions
    folder : Path
        Folder for checkpoints and the curve.
    device : "cpu" or "cuda"
        Device that the network learns on.
    tell : callable, optional
        Called after each epoch with epochs done, epochs in all, and the losses in words.

    Raises
    ------
    CheckpointError
        The folder holds a training with other pictures, options or parent.
    """
    chosen = find_device(device)
    vae.to(chosen)
    items = SizedPictures(train_frames, vae.size, BACKGROUND_COPIES)
    held = SizedPictures(validation, vae.size)
    before = reconstruction_error(vae, held)
    recipe = digest_of({"fine-tuned from": parent, "augmentation": vars(AUGMENTATION), "options": options.shaping})
    stamps = TrainedOn(recipe, train_frames.split_digest, digest_of([items.fingerprint, held.fingerprint]), "")
    # a parent without a list of its sensors stays without one: a partial list would seem complete
    if vae.learned_from:
        vae.learned_from += kept_small(list(train_frames.backgrounds().items()))
    objective = ImageVaeObjective(vae, DIVERGENCE_WEIGHT, 0, AUGMENTATION)
    train(objective, items, held, options, folder, stamps, chosen, tell=tell)
    return FineTuned(folder / BEST, len(train_frames), before, reconstruction_error(vae, held))


def reconstruction_error(vae: ImageVae, items: SizedPictures) -> float:
    """Mean difference, grey levels, between pictures and what the VAE encodes and decodes of them."""
    true = items.batch(range(len(items)))["image"].numpy()
    return float(IMAGE_SIMILARITY.scores["l1"](decode_pictures(vae, encode_pictures(vae, true)), true).mean())
