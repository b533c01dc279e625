"""Grey levels mapped, channel by channel, so that the source background gets the target background's histogram."""

from __future__ import annotations

import numpy as np

from split_models.transfer.pixels.base import LEVELS, PixelTransfer
from tactiledata.arrays import SingleArray


def match(images: SingleArray, source_background: SingleArray, target_background: SingleArray) -> SingleArray:
    """Each channel through the map that takes one background's histogram to the other's."""
    changed = np.empty_like(images)
    for channel in range(3):
        table = level_map(source_background[..., channel], target_background[..., channel])
        changed[..., channel] = table[images[..., channel].astype(np.intp)]
    return changed


def level_map(source: SingleArray, target: SingleArray) -> SingleArray:
    """New level (256,) of each old one.

    The map comes from the two backgrounds, not from each picture: a touch is what is to be kept, and must not be
    mistaken for style. Levels that the source background does not reach are moved as far as its nearest end, so that
    highlights and shadows of a touch keep their contrast.
    """
    levels, counts = np.unique(source.astype(np.intp), return_counts=True)
    goals, goal_counts = np.unique(target.astype(np.intp), return_counts=True)
    matched = np.interp(np.cumsum(counts) / source.size, np.cumsum(goal_counts) / target.size, goals)
    every = np.arange(LEVELS)
    table = np.interp(every, levels, matched)
    low, high = every < levels[0], every > levels[-1]
    table[low] = matched[0] + (every - levels[0])[low]
    table[high] = matched[-1] + (every - levels[-1])[high]
    return table.astype(np.float32)


HISTOGRAM_MATCHING = PixelTransfer(
    "histogram_matching",
    "per-channel histogram matching",
    "the classical map between cumulative histograms (as scikit-image's match_histograms), taken from the backgrounds",
    match,
)
