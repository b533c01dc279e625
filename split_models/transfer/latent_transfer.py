"""Transfer between sensors by latent arithmetic: encode, subtract one background, add the other, decode."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from split_models.learning.checkpoint import load_checkpoint
from split_models.learning.device import find_device
from split_models.networks.image_vae import ImageVae
from split_models.networks.latent import add, decode_pictures, encode_pictures, subtract
from split_models.networks.learned_backgrounds import Learned
from split_models.transfer.picture_size import scaled
from split_models.transfer.pixels.relight_change import relit_change
from tactiledata.arrays import PictureArray, SingleArray
from tactiledata.contract.provenance import file_digest
from tactiledata.errors import CheckpointError

Laid = Literal["", "change", "ratio", "relit"]
LAID: dict[str, Laid] = {
    "latent": "",
    "latent_on_background": "change",
    "latent_ratio_on_background": "ratio",
    "latent_relit": "relit",
}
"""How each method uses the target's recorded background; empty: not at all, the picture is the decoder's."""
DECODED_SHARE = 0.25
"""Share of the decoded change in ``relit``; the rest is the recorded change in the target's light (decision 0042)."""
DARKEST = 8.0
"""Least grey level in a ratio of light; darker pixels count as this level, because their ratio is mostly noise."""


@dataclass(frozen=True)
class LatentTransfer:
    """The paper's transfer by an image VAE.

    Parameters
    ----------
    name : str
        Name of the method.
    vae : ImageVae
        Pictures are scaled to its size, and back to the target background's.
    laid : "", "change", "ratio" or "relit"
        How the decoded picture is combined with the target's recorded background. ``change`` adds its difference to the
        decoded background, ``ratio`` multiplies by its ratio to it; both keep the background's details, which decoding
        loses. ``relit`` adds a weighted mean of that difference and of the recorded touch in the target's light, which
        keeps the touch's details as well. Empty gives the decoded picture itself.
    model, recipe : str
        SHA-256 of the checkpoint's file, and of the recipe that it was trained by.
    scales : bool
        Whether source and target may have pictures of different sizes.
    """

    name: str
    vae: ImageVae
    laid: Laid = ""
    model: str = ""
    recipe: str = ""
    scales: bool = True

    @property
    def learned_from(self) -> Learned:
        """Sensors that the VAE was trained on, with their pictures without contact; empty where that is not known."""
        return self.vae.learned_from

    def transfer(
        self, images: PictureArray, source_background: PictureArray, target_background: PictureArray
    ) -> PictureArray:
        """Pictures (n, H, W, 3) uint8 as the target sensor might have recorded them, in its background's size.

        Parameters
        ----------
        images : (n, h, w, 3) uint8 RGB
            Pictures of the source sensor.
        source_background, target_background : (h, w, 3) and (H, W, 3) uint8 RGB
            Source and target without contact.
        """
        size = target_background.shape[:2]
        if not len(images):
            return np.zeros((0, *size, 3), np.uint8)
        source, target = (
            encode_pictures(self.vae, scaled(background[None], self.vae.size))
            for background in (source_background, target_background)
        )
        touched = encode_pictures(self.vae, scaled(images, self.vae.size))
        drawn = scaled(decode_pictures(self.vae, add(subtract(touched, source), target)), size)
        if not self.laid:
            return drawn
        untouched = scaled(decode_pictures(self.vae, target), size)
        if self.laid == "relit":
            base = scaled(source_background[None], size)[0].astype(np.float32)
            recorded = scaled(images, size) - base
            return mixed_on(target_background, drawn.astype(np.float32) - untouched, recorded, base)
        return laid_on(target_background, drawn, untouched, self.laid)


def mixed_on(
    background: PictureArray, decoded: SingleArray, recorded: SingleArray, source_background: SingleArray
) -> PictureArray:
    """Pictures (n, H, W, 3), uint8: a mean of decoded and of relit changes on a recorded background.

    Parameters
    ----------
    background : (H, W, 3) uint8
        Recorded background of the target.
    decoded, recorded : (n, H, W, 3) float32, grey levels
        Changes by touches: as decoded for the target, and as recorded by the source.
    source_background : (H, W, 3) float32, grey levels
        Recorded background of the source.
    """
    goal = background.astype(np.float32)
    change = DECODED_SHARE * decoded + (1 - DECODED_SHARE) * relit_change(recorded, source_background, goal)
    return np.clip(np.rint(goal + change), 0, 255).astype(np.uint8)


def laid_on(background: PictureArray, drawn: PictureArray, untouched: PictureArray, laid: Laid) -> PictureArray:
    """Pictures (n, H, W, 3), uint8: the touches of decoded pictures on a recorded background.

    Parameters
    ----------
    background : (H, W, 3) uint8
        Recorded background of the target.
    drawn : (n, H, W, 3) uint8
        Decoded pictures of touches.
    untouched : (1, H, W, 3) uint8
        Decoded background of the target.
    laid : "change" or "ratio"
        Whether the decoded pictures' difference to the decoded background is added, or their ratio multiplies.
    """
    if laid == "change":
        combined = background + (drawn.astype(np.float32) - untouched)
    else:
        combined = background * (np.maximum(drawn, DARKEST) / np.maximum(untouched, DARKEST).astype(np.float32))
    return np.clip(np.rint(combined), 0, 255).astype(np.uint8)


def load_image_vae(path: Path, device: str = "cpu") -> tuple[ImageVae, str, str]:
    """The image VAE in a checkpoint, the SHA-256 of its file, and that of the recipe that it was trained by.

    Parameters
    ----------
    path : Path
    device : "cpu" or "cuda"
        Device that the VAE runs on.

    Raises
    ------
    UnknownName, UsageError
        As `split_models.learning.device.find_device`.
    MissingFile
        The file does not exist.
    CheckpointError
        The file is no checkpoint, or one of another kind of network.
    """
    checkpoint = load_checkpoint(path)
    network = checkpoint.network()
    if not isinstance(network, ImageVae):
        raise CheckpointError(
            f"{path} holds a {checkpoint.kind}" + (" for one mesh topology" if checkpoint.topology else ""),
            "an image_vae: only pictures are encoded and decoded here",
            "Name the image VAE's checkpoint of the run.",
            path=str(path),
        )
    return network.to(find_device(device)), file_digest(path), checkpoint.stamps.recipe
