"""Runs of images that are read together: few enough that their pixels fit into little memory."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

PIXELS_AT_ONCE = 2**25
"""Largest number of pixels in one run, 96 MiB of RGB (256 images of 320 x 240 are fewer); one image may have more."""


def image_batches(
    pixels: NDArray[np.int64], most_images: int, most_pixels: int = PIXELS_AT_ONCE
) -> Iterator[tuple[int, int]]:
    """The start and the end (not included) of runs of consecutive images, in order, each within two limits.

    Parameters
    ----------
    pixels : (n,) int64
        Of each image.
    most_images : int
        Of one run.
    most_pixels : int
        Of one run. An image that has more alone is a run of its own.

    Examples
    --------
    >>> list(image_batches(np.array([4, 4, 4, 90, 4]), most_images=2, most_pixels=10))
    [(0, 2), (2, 3), (3, 4), (4, 5)]
    """
    start = 0
    while start < len(pixels):
        within = np.cumsum(pixels[start : start + most_images]) <= most_pixels
        stop = start + max(1, int(within.sum()))
        yield start, stop
        start = stop
