"""One background exchanged for the other as light is: by the ratio of both, pixel by pixel."""

from __future__ import annotations

import numpy as np

from split_models.transfer.pixels.base import PixelTransfer
from tactiledata.arrays import SingleArray

DARKEST = 8.0
"""Grey levels; a ratio of darker pixels is one of noise, and counts as if they were so bright."""


def relight(images: SingleArray, source_background: SingleArray, target_background: SingleArray) -> SingleArray:
    """Target background plus the picture's change, scaled by how much brighter the target is.

    Where both backgrounds are brighter than `DARKEST` that is picture times target background over source background.
    """
    gain = np.maximum(target_background, DARKEST) / np.maximum(source_background, DARKEST)
    return np.asarray(target_background + (images - source_background) * gain, np.float32)


BACKGROUND_RATIO = PixelTransfer(
    "background_ratio",
    "background ratio",
    "beyond the paper: a touch as a ratio of light, as optics have it and as the rig draws it",
    relight,
)
