"""The target's picture without contact, whatever the touch: what a score gives to someone who transfers nothing."""

from __future__ import annotations

import numpy as np

from split_models.transfer.pixels.base import PixelTransfer
from tactiledata.arrays import SingleArray


def target_alone(images: SingleArray, source_background: SingleArray, target_background: SingleArray) -> SingleArray:
    """The target background, once for each picture."""
    return np.broadcast_to(target_background, images.shape)


NO_CONTACT = PixelTransfer("no_contact", "target background without contact", "the row that says nothing", target_alone)
