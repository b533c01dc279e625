"""Pictures scaled to the size that a network takes, or back to that of a background."""

from __future__ import annotations

import cv2
import numpy as np

from tactiledata.arrays import PictureArray


def scaled(pictures: PictureArray, size: tuple[int, int]) -> PictureArray:
    """Pictures scaled to (n, *size, 3), averaged where they shrink and interpolated where they grow.

    Pictures that already have the size are returned as they are. Landscape pictures are rotated by a quarter turn for
    an upright size, and upright ones the other way for a landscape size.
    """
    if pictures.shape[1:3] == tuple(size):
        return pictures
    rows, columns = pictures.shape[1:3]
    if (rows - columns) * (size[0] - size[1]) < 0:
        pictures = np.ascontiguousarray(np.rot90(pictures, 1 if rows < columns else -1, axes=(1, 2)))
    if pictures.shape[1:3] == tuple(size):
        return pictures
    way = cv2.INTER_AREA if size[0] < pictures.shape[1] else cv2.INTER_LINEAR
    return np.stack([np.asarray(cv2.resize(picture, size[::-1], interpolation=way), np.uint8) for picture in pictures])
