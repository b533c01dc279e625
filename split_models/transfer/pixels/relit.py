"""The touch is laid on the target background in the target's light, without the source camera's noise."""

from __future__ import annotations

from split_models.transfer.pixels.base import PixelTransfer
from split_models.transfer.pixels.relight_change import relit_change
from tactiledata.arrays import SingleArray


def lay_relit(images: SingleArray, source_background: SingleArray, target_background: SingleArray) -> SingleArray:
    """The target background plus the change of each picture in the target's light.

    Parameters
    ----------
    images : (n, H, W, 3) float32, grey levels
        Pictures of the source sensor.
    source_background, target_background : (H, W, 3) float32, grey levels
        Source and target without contact.
    """
    return target_background + relit_change(images - source_background, source_background, target_background)


RELIT = PixelTransfer(
    "relit",
    "touch in the target's light",
    "beyond the paper: the change without camera noise, times the smooth ratio of both backgrounds",
    lay_relit,
    scales=True,
)
