"""One background exchanged for the other, pixel by pixel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from split_models.transfer.pixels.base import PixelTransfer

Floats = NDArray[np.float32]


def swap(images: Floats, source_background: Floats, target_background: Floats) -> Floats:
    """Picture minus source background plus target background."""
    return images - source_background + target_background


BACKGROUND_SWAP = PixelTransfer("background_swap", "background swap", "latent arithmetic, done on pixels", swap)
