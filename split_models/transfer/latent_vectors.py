"""Vectors of touches to compare sensors by: an image VAE's, or without a model the pictures themselves, small."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import PictureArray

Vectors = dict[str, NDArray[np.float32]]
SIZE = (20, 15)
"""Rows and columns of a picture as a vector."""


def picture_vectors(pictures: PictureArray, background: PictureArray | None) -> Vectors:
    """Pictures (n, H, W, 3) shrunk to 20 x 15, as vectors, and their difference to the background's.

    The stand-in for latent vectors where there is no model: ``pixels`` for Z_image, ``pixels - background`` for
    Z_deform.
    """
    small = _small(pictures)
    found = {"pixels": small}
    if background is not None:
        found["pixels - background"] = small - _small(background[None])
    return found


def _small(pictures: PictureArray) -> NDArray[np.float32]:
    shrunk = [cv2.resize(one.astype(np.float32), SIZE[::-1], interpolation=cv2.INTER_AREA) for one in pictures]
    return np.stack(shrunk).reshape(len(pictures), -1)


def vectors_by_model(path: Path) -> Callable[[PictureArray, PictureArray | None], Vectors]:
    """Z_image, and Z_deform where the sensor has a background, by the image VAE in a checkpoint.

    Raises
    ------
    MissingFile, CheckpointError
        No such file; not an image VAE's.
    """
    from split_models.networks.latent import encode_pictures, subtract
    from split_models.transfer.latent_transfer import load_image_vae, scaled

    vae, _, _ = load_image_vae(path)

    def encode(pictures: PictureArray, background: PictureArray | None) -> Vectors:
        image = encode_pictures(vae, scaled(pictures, vae.size))
        found = {"Z_image": image.numpy()}
        if background is not None:
            base = encode_pictures(vae, scaled(background[None], vae.size))
            found["Z_deform"] = subtract(image, base).numpy()
        return found

    return encode
