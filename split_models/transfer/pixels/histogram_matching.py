"""Grey levels are mapped channel by channel, so that the source background takes the target background's histogram."""

from __future__ import annotations

import numpy as np

from split_models.transfer.pixels.base import LEVELS, PixelTransfer
from tactiledata.arrays import SingleArray


def match(images: SingleArray, source_background: SingleArray, target_background: SingleArray) -> SingleArray:
    """Pictures whose channels pass the maps that take the source background's histograms to the target background's.

    Parameters
    ----------
    images : (n, H, W, 3) float32, grey levels
        Pictures of the source sensor.
    source_background, target_background : (H, W, 3) float32, grey levels
        Source and target without contact.
    """
    changed = np.empty_like(images)
    for channel in range(3):
        table = level_map(source_background[..., channel], target_background[..., channel])
        changed[..., channel] = table[images[..., channel].astype(np.intp)]
    return changed


def level_map(source: SingleArray, target: SingleArray) -> SingleArray:
    """New grey level (256,) of each old one, for one channel of the backgrounds (H, W).

    The map comes from the two backgrounds and not from each picture, because a touch must be kept and not be mistaken
    for style. Levels beyond the source background's range are shifted as far as the nearest end of that range, so that
    highlights and shadows of a touch keep their contrast.
    """
    levels, counts = np.unique(source.astype(np.intp), return_counts=True)
    goals, goal_counts = np.unique(target.astype(np.intp), return_counts=True)
    matched = np.interp(np.cumsum(counts) / source.size, np.cumsum(goal_counts) / target.size, goals)
    all_levels = np.arange(LEVELS)
    table = np.interp(all_levels, levels, matched)
    low, high = all_levels < levels[0], all_levels > levels[-1]
    table[low] = matched[0] + (all_levels - levels[0])[low]
    table[high] = matched[-1] + (all_levels - levels[-1])[high]
    return table.astype(np.float32)


HISTOGRAM_MATCHING = PixelTransfer(
    "histogram_matching",
    "per-channel histogram matching",
    "the classical map between cumulative histograms (as scikit-image's match_histograms), taken from the backgrounds",
    match,
)
