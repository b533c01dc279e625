"""The source background is exchanged for the target's as a difference, pixel by pixel."""

from __future__ import annotations

from split_models.transfer.pixels.base import PixelTransfer
from tactiledata.arrays import SingleArray


def swap(images: SingleArray, source_background: SingleArray, target_background: SingleArray) -> SingleArray:
    """The picture minus the source background plus the target background.

    Parameters
    ----------
    images : (n, H, W, 3) float32, grey levels
        Pictures of the source sensor.
    source_background, target_background : (H, W, 3) float32, grey levels
        Source and target without contact.
    """
    return images - source_background + target_background


BACKGROUND_SWAP = PixelTransfer("background_swap", "background swap", "latent arithmetic, done on pixels", swap)
