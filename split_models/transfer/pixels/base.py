"""What a transfer by pixels is: pictures of one sensor and two pictures without contact in, pictures of another out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import PictureArray
from tactiledata.errors import UsageError

LEVELS = 256


@dataclass(frozen=True)
class PixelTransfer:
    """One method.

    Parameters
    ----------
    name : str
        As on the command line and in tables.
    title : str
        For people.
    source : str
        Where the method is from.
    change : callable
        ``change(images, source_background, target_background)``: float32 in and out, grey levels.
    """

    name: str
    title: str
    source: str
    change: Callable[[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]], NDArray[np.float32]]

    def transfer(
        self, images: PictureArray, source_background: PictureArray, target_background: PictureArray
    ) -> PictureArray:
        """The touches as the target sensor might have seen them.

        Parameters
        ----------
        images : (n, H, W, 3) uint8 RGB
            All of one sensor.
        source_background, target_background : (H, W, 3) uint8 RGB
            That sensor and the target without contact.

        Returns
        -------
        (n, H, W, 3) uint8 RGB, rounded and clipped

        Raises
        ------
        UsageError
            Other shapes or types, or sizes that differ.
        """
        check_pictures(images, source_background, target_background)
        if not len(images):
            return images.copy()
        changed = self.change(*(one.astype(np.float32) for one in (images, source_background, target_background)))
        return np.clip(np.rint(changed), 0, LEVELS - 1).astype(np.uint8)


def check_pictures(images: PictureArray, source_background: PictureArray, target_background: PictureArray) -> None:
    """Nothing, where pictures and both backgrounds are uint8 RGB of one size.

    Raises
    ------
    UsageError
        They are not.
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
