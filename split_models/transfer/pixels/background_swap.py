"""One background exchanged for the other, pixel by pixel."""

from __future__ import annotations

from split_models.transfer.pixels.base import PixelTransfer
from tactiledata.arrays import SingleArray


def swap(images: SingleArray, source_background: SingleArray, target_background: SingleArray) -> SingleArray:
    """Picture minus source background plus target background."""
    return images - source_background + target_background


BACKGROUND_SWAP = PixelTransfer("background_swap", "background swap", "latent arithmetic, done on pixels", swap)
