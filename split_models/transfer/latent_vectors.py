"""Vectors of pictures by which sensors are compared: an image VAE's latent vectors, or small pictures without one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import PictureArray

Vectors = dict[str, NDArray[np.float32]]
SIZE = (20, 15)
"""Rows and columns of a picture that becomes a vector."""


def picture_vectors(pictures: PictureArray, background: PictureArray | None) -> Vectors:
    """Vectors (n, 300) of pictures (n, H, W, 3) scaled to 20 x 15, and their differences to the background's vector.

    They replace latent vectors where there is no model: ``pixels`` for Z_image, ``pixels - background`` for Z_deform.
    """
    small = _small(pictures)
    vectors = {"pixels": small}
    if background is not None:
        vectors["pixels - background"] = small - _small(background[None])
    return vectors


def _small(pictures: PictureArray) -> NDArray[np.float32]:
    """Vectors (n, 300) of pictures, scaled by area."""
    shrunk = [cv2.resize(picture.astype(np.float32), SIZE[::-1], interpolation=cv2.INTER_AREA) for picture in pictures]
    return np.stack(shrunk).reshape(len(pictures), -1)


def vectors_by_model(path: Path, device: str = "cpu") -> Callable[[PictureArray, PictureArray | None], Vectors]:
    """A function of pictures and background that gives Z_image, and with a background Z_deform, by an image VAE.

    Parameters
    ----------
    path : Path
    device : "cpu" or "cuda"
        Device that the image VAE runs on.

    Raises
    ------
    MissingFile
        The file does not exist.
    CheckpointError
        The file holds no image VAE.
    """
    from split_models.networks.latent import encode_pictures, subtract
    from split_models.transfer.latent_transfer import load_image_vae
    from split_models.transfer.picture_size import scaled

    vae, _, _ = load_image_vae(path, device)

    def encode(pictures: PictureArray, background: PictureArray | None) -> Vectors:
        image = encode_pictures(vae, scaled(pictures, vae.size))
        vectors = {"Z_image": image.numpy()}
        if background is not None:
            base = encode_pictures(vae, scaled(background[None], vae.size))
            vectors["Z_deform"] = subtract(image, base).numpy()
        return vectors

    return encode
