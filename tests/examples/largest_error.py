"""A metric of one's own: the largest difference of any pixel, on the full frame or inside a contact mask."""

import numpy as np

from tactiledata.metrics.base import Score, image_pairs, metric


def largest(predicted, true, mask=None):
    """Largest absolute difference (n,), grey levels; NaN where a mask is empty."""
    ours, theirs, inside = image_pairs(predicted, true, mask)
    difference = np.abs(ours.astype(np.int16) - theirs).max(axis=3).reshape(len(ours), -1).astype(float)
    if inside is None:
        return difference.max(axis=1)
    within = inside.reshape(len(ours), -1)
    return np.where(within.any(axis=1), np.where(within, difference, 0).max(axis=1), np.nan)


LARGEST_ERROR = metric(
    "largest_error",
    "the worst pixel",
    "images",
    [Score("largest", "largest error", "grey levels", "lower", 0.0, largest)],
)
