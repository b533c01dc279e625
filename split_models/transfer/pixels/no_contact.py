"""The target background for every touch: the score of transferring nothing."""

from __future__ import annotations

import numpy as np

from split_models.transfer.pixels.base import PixelTransfer
from tactiledata.arrays import SingleArray


def target_alone(images: SingleArray, source_background: SingleArray, target_background: SingleArray) -> SingleArray:
    """The target background, repeated for each picture.

    Parameters
    ----------
    images : (n, H, W, 3) float32
        Pictures of the source sensor, which give the number.
    source_background : (H, W, 3) float32
        Not used.
    target_background : (H, W, 3) float32, grey levels
        The target without contact.
    """
    return np.broadcast_to(target_background, images.shape)


NO_CONTACT = PixelTransfer("no_contact", "target background without contact", "the row that says nothing", target_alone)
