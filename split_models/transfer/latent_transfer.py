"""Transfer between sensors by latent arithmetic: encode, subtract one background, add the other, decode."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import cv2
import numpy as np

from split_models.learning.checkpoint import load_checkpoint
from split_models.networks.image_vae import ImageVae
from split_models.networks.latent import add, decode_pictures, encode_pictures, subtract
from split_models.networks.learned_backgrounds import Learned
from tactiledata.arrays import PictureArray
from tactiledata.contract.provenance import file_digest
from tactiledata.errors import CheckpointError

Laid = Literal["", "change", "ratio"]
LAID: dict[str, Laid] = {"latent": "", "latent_on_background": "change", "latent_ratio_on_background": "ratio"}
"""What each method lays on the target's own background; empty: nothing, the picture is the decoder's."""
DARKEST = 8.0
"""Grey levels of the decoded background below which a ratio counts as if it were so bright."""


@dataclass(frozen=True)
class LatentTransfer:
    """The paper's transfer, by an image VAE.

    Parameters
    ----------
    name : str
    vae : ImageVae
        Pictures are scaled to its size, and back to the target background's.
    laid : "", "change" or "ratio"
        Of what is decoded only the change against the decoded background is taken, as a difference or as a ratio of
        light, and laid on the target's own background: what the VAE smooths away of that stays.
    model, recipe : str
        SHA-256 of the checkpoint's file, and of the recipe that it was trained by.
    scales : bool
        Source and target may have pictures of different sizes.
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
        """The touches (n, H, W, 3) uint8 as the target sensor might have seen them, in its background's size."""
        size = target_background.shape[:2]
        if not len(images):
            return np.zeros((0, *size, 3), np.uint8)
        source, target = (
            encode_pictures(self.vae, scaled(one[None], self.vae.size))
            for one in (source_background, target_background)
        )
        touched = encode_pictures(self.vae, scaled(images, self.vae.size))
        drawn = scaled(decode_pictures(self.vae, add(subtract(touched, source), target)), size)
        if not self.laid:
            return drawn
        return laid_on(target_background, drawn, scaled(decode_pictures(self.vae, target), size), self.laid)


def laid_on(background: PictureArray, drawn: PictureArray, untouched: PictureArray, laid: Laid) -> PictureArray:
    """What tells drawn pictures (n, H, W, 3) from an untouched one (1, H, W, 3), laid on a background (H, W, 3)."""
    if laid == "change":
        whole = background + (drawn.astype(np.float32) - untouched)
    else:
        whole = background * (np.maximum(drawn, DARKEST) / np.maximum(untouched, DARKEST).astype(np.float32))
    return np.clip(np.rint(whole), 0, 255).astype(np.uint8)


def scaled(pictures: PictureArray, size: tuple[int, int]) -> PictureArray:
    """Pictures (n, *size, 3): averaged where they shrink, interpolated where they grow; as they are where they fit.

    Where pictures lie and the size is upright they are turned a quarter, and back the other way round.
    """
    if pictures.shape[1:3] == tuple(size):
        return pictures
    rows, columns = pictures.shape[1:3]
    if (rows - columns) * (size[0] - size[1]) < 0:
        pictures = np.ascontiguousarray(np.rot90(pictures, 1 if rows < columns else -1, axes=(1, 2)))
    if pictures.shape[1:3] == tuple(size):
        return pictures
    way = cv2.INTER_AREA if size[0] < pictures.shape[1] else cv2.INTER_LINEAR
    return np.stack([np.asarray(cv2.resize(one, size[::-1], interpolation=way), np.uint8) for one in pictures])


def load_image_vae(path: Path) -> tuple[ImageVae, str, str]:
    """The image VAE in a checkpoint, and SHA-256 of the file and of the recipe that it was trained by.

    Raises
    ------
    MissingFile, CheckpointError
        No such file; not a checkpoint; one of another kind of network.
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
    return network, file_digest(path), checkpoint.stamps.recipe
