"""The base of pixel transfers: pictures of one sensor and two backgrounds in, pictures in the other's style out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from split_models.transfer.picture_size import scaled
from tactiledata.arrays import PictureArray
from tactiledata.errors import UsageError

LEVELS = 256
"""Grey levels of a picture."""


@dataclass(frozen=True)
class PixelTransfer:
    """A transfer method that computes on pixels.

    Parameters
    ----------
    name : str
        Name on the command line and in tables.
    title : str
        Title for people.
    source : str
        Publication or idea that the method comes from.
    change : callable
        ``change(images, source_background, target_background)`` of float32 arrays, grey levels, that gives the new
        pictures, not yet rounded.
    scales : bool
        Whether pictures and background of the source are first scaled to the target background's size; otherwise other
        sizes are refused.
    """

    name: str
    title: str
    source: str
    change: Callable[[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]], NDArray[np.float32]]
    scales: bool = False

    def transfer(
        self, images: PictureArray, source_background: PictureArray, target_background: PictureArray
    ) -> PictureArray:
        """Pictures (n, H, W, 3), uint8, as the target sensor might have recorded them.

        Parameters
        ----------
        images : (n, H, W, 3) uint8 RGB
            Pictures of the source sensor.
        source_background, target_background : (H, W, 3) uint8 RGB
            Source and target without contact.

        Returns
        -------
        (n, H, W, 3) uint8 RGB, rounded and clipped

        Raises
        ------
        UsageError
            Shapes, types or sizes differ from these.
        """
        if self.scales and images.ndim == 4 and source_background.shape == images.shape[1:]:
            size = target_background.shape[:2]
            images, source_background = scaled(images, size), scaled(source_background[None], size)[0]
        check_pictures(images, source_background, target_background)
        if not len(images):
            return images.copy()
        changed = self.change(
            *(picture.astype(np.float32) for picture in (images, source_background, target_background))
        )
        return np.clip(np.rint(changed), 0, LEVELS - 1).astype(np.uint8)


def check_pictures(images: PictureArray, source_background: PictureArray, target_background: PictureArray) -> None:
    """Refuse pictures and backgrounds that are not uint8 RGB of one size.

    Parameters
    ----------
    images : (n, H, W, 3) uint8 RGB
    source_background, target_background : (H, W, 3) uint8 RGB

    Raises
    ------
    UsageError
        A shape, a type or a size differs.
    """
    if images.ndim != 4 or images.shape[3] != 3 or images.dtype != np.uint8:
        raise UsageError(f"pictures of shape {images.shape}, {images.dtype}", "(n, H, W, 3) uint8 RGB")
    for what, picture in (("source", source_background), ("target", target_background)):
        if picture.shape != images.shape[1:] or picture.dtype != np.uint8:
            raise UsageError(
                f"the {what} background has shape {picture.shape}, {picture.dtype}",
                f"that of the pictures, {images.shape[1:]}, uint8 RGB",
                "Take a background of the pictures' size, or resize it first.",
            )
