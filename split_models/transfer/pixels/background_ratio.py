"""The source background is exchanged for the target's as light is: by the ratio of both, pixel by pixel."""

from __future__ import annotations

import numpy as np

from split_models.transfer.pixels.base import PixelTransfer
from tactiledata.arrays import SingleArray

DARKEST = 8.0
"""Least grey level in a ratio of light; darker pixels count as this level, because their ratio is mostly noise."""


def relight(images: SingleArray, source_background: SingleArray, target_background: SingleArray) -> SingleArray:
    """The target background plus the picture's change, scaled by the ratio of the backgrounds.

    Where both backgrounds are brighter than `DARKEST`, that is picture times target background over source background.

    Parameters
    ----------
    images : (n, H, W, 3) float32, grey levels
        Pictures of the source sensor.
    source_background, target_background : (H, W, 3) float32, grey levels
        Source and target without contact.
    """
    gain = np.maximum(target_background, DARKEST) / np.maximum(source_background, DARKEST)
    return np.asarray(target_background + (images - source_background) * gain, np.float32)


BACKGROUND_RATIO = PixelTransfer(
    "background_ratio",
    "background ratio",
    "beyond the paper: a touch as a ratio of light, as optics have it and as the rig draws it",
    relight,
)
