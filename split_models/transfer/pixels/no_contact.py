"""The target's picture without contact, whatever the touch: what a score gives to someone who transfers nothing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from split_models.transfer.pixels.base import PixelTransfer

Floats = NDArray[np.float32]


def target_alone(images: Floats, source_background: Floats, target_background: Floats) -> Floats:
    """The target background, once for each picture."""
    return np.broadcast_to(target_background, images.shape)


NO_CONTACT = PixelTransfer("no_contact", "target background without contact", "the row that says nothing", target_alone)
