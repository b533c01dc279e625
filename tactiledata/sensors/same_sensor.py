"""A test of whether two pictures without contact are of one sensor."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

SAME_GEL_LEVELS = 6.0
"""Mean absolute difference, of 255 levels, up to which two pictures show the same sensor.

The two most alike of the 18 bundled DIGITs differ by 7.2 (7.0 at 40 x 30 px), the median pair by 17.7; one sensor's
exposure drifts by a few levels."""


def levels_apart(first: NDArray[np.uint8], second: NDArray[np.uint8]) -> float:
    """Mean absolute difference, grey levels, of two pictures (H, W, 3), both at the smaller of their sizes."""
    rows, columns = np.minimum(first.shape[:2], second.shape[:2]).tolist()
    return float(np.abs(_sized(first, rows, columns).astype(np.int16) - _sized(second, rows, columns)).mean())


def is_same_sensor(first: NDArray[np.uint8], second: NDArray[np.uint8]) -> bool:
    """Whether two pictures without contact (H, W, 3) differ by no more than one sensor's pictures do."""
    return levels_apart(first, second) <= SAME_GEL_LEVELS


def _sized(picture: NDArray[np.uint8], rows: int, columns: int) -> NDArray[np.uint8]:
    """Return a picture at a size; the same where it has that size."""
    if picture.shape[:2] == (rows, columns):
        return picture
    return np.asarray(cv2.resize(picture, (columns, rows), interpolation=cv2.INTER_AREA), np.uint8)
