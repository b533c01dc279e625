"""Similarity of the colours of two sets of pictures: histogram intersection and histogram correlation.

The text of the SPLIT paper describes the intersection, the head of its table says correlation: both are here.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UsageError
from tactiledata.metrics.base import Score, Values, image_masks, images, metric

BINS = 32
"""Bins of each channel: eight grey levels wide, so that noise moves few pixels between them."""


def histograms(pictures: Any, mask: Any = None) -> Values:
    """Histograms (n, 3, BINS) of pictures (n, H, W, 3), each channel of sum 1; NaN where a mask (n, H, W) is empty."""
    batch = images(pictures, "pictures")
    inside = image_masks(mask, batch)
    shares = np.empty((len(batch), 3, BINS))
    for row, picture in enumerate(batch):
        pixels = picture.reshape(-1, 3) if inside is None else picture[inside[row]]
        level = pixels // (256 // BINS)
        for channel in range(3):
            counts = np.bincount(level[:, channel], minlength=BINS)
            shares[row, channel] = counts / counts.sum() if len(level) else np.nan
    return shares


def histogram_intersection(pictures: Any, others: Any, mask: Any = None, others_mask: Any = None) -> Values:
    """Overlap (n,), 0 to 1, of the histogram of each picture with the mean one of the other set, mean over channels.

    Parameters
    ----------
    pictures : (n, H, W, 3) uint8
        Pictures to score.
    others : (m, H, W, 3) uint8
        Pictures of the other set.
    mask : (n, H, W) bool, optional
        Restricts the pictures to their contacts; a picture with an empty mask is NaN.
    others_mask : (m, H, W) bool, optional
        The same of the other set, whose pictures with an empty mask are left out.
    """
    ours, theirs = histograms(pictures, mask), _mean(histograms(others, others_mask))
    return np.minimum(ours, theirs).sum(axis=2).mean(axis=1)


def histogram_correlation(pictures: Any, others: Any, mask: Any = None, others_mask: Any = None) -> Values:
    """Pearson's correlation (n,), -1 to 1, of each histogram with the mean one of the other set, mean over channels.

    Parameters
    ----------
    pictures : (n, H, W, 3) uint8
        Pictures to score.
    others : (m, H, W, 3) uint8
        Pictures of the other set.
    mask : (n, H, W) bool, optional
        Restricts the pictures to their contacts; a picture with an empty mask is NaN.
    others_mask : (m, H, W) bool, optional
        The same of the other set, whose pictures with an empty mask are left out.
    """
    ours, theirs = histograms(pictures, mask), _mean(histograms(others, others_mask))
    ours, theirs = ours - ours.mean(axis=2, keepdims=True), theirs - theirs.mean(axis=1, keepdims=True)
    sizes = np.linalg.norm(ours, axis=2) * np.linalg.norm(theirs, axis=1)
    return ((ours * theirs).sum(axis=2) / np.maximum(sizes, 1e-12)).mean(axis=1)


def _mean(shares: NDArray[np.float64]) -> Values:
    """Mean histogram (3, BINS) of those (m, 3, BINS) that are not NaN; refuse a set without any."""
    is_there = ~np.isnan(shares[:, 0, 0])
    if not is_there.any():
        raise UsageError(f"none of {len(shares)} pictures of the other set has a pixel in its mask", "at least one", "")
    mean: Values = shares[is_there].mean(axis=0)
    return mean


HISTOGRAM = metric(
    "histogram",
    "how alike the colours of each picture and of another set are",
    "image sets",
    [
        Score("histogram_intersection", "histogram intersection", "", "higher", 1.0, histogram_intersection),
        Score("histogram_correlation", "histogram correlation", "", "higher", 1.0, histogram_correlation),
    ],
)
