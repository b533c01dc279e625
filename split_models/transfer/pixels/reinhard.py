"""Reinhard colour transfer: mean and spread of each CIELAB axis are moved from one background's to the other's."""

from __future__ import annotations

import cv2
import numpy as np

from split_models.transfer.pixels.base import LEVELS, PixelTransfer
from tactiledata.arrays import SingleArray

LEAST_SPREAD = 1e-3
"""Least spread of an axis, in units of CIELAB, by which pictures are scaled; below it they are only shifted."""


def transfer_colour(images: SingleArray, source_background: SingleArray, target_background: SingleArray) -> SingleArray:
    """Pictures whose CIELAB axes are shifted and scaled from the source background's statistics to the target's.

    Parameters
    ----------
    images : (n, H, W, 3) float32, grey levels
        Pictures of the source sensor.
    source_background, target_background : (H, W, 3) float32, grey levels
        Source and target without contact.
    """
    mean, spread = statistics(source_background)
    goal_mean, goal_spread = statistics(target_background)
    scale = np.where(spread > LEAST_SPREAD, goal_spread / np.maximum(spread, LEAST_SPREAD), 1.0).astype(np.float32)
    return np.stack([_rgb((_lab(image) - mean) * scale + goal_mean) for image in images])


def statistics(picture: SingleArray) -> tuple[SingleArray, SingleArray]:
    """Mean and standard deviation (3,) of a picture (H, W, 3) in CIELAB."""
    lab = _lab(picture).reshape(-1, 3)
    return lab.mean(axis=0), lab.std(axis=0)


def _lab(picture: SingleArray) -> SingleArray:
    """A picture (H, W, 3) in CIELAB, from grey levels."""
    return np.asarray(cv2.cvtColor(picture / np.float32(LEVELS - 1), cv2.COLOR_RGB2LAB))


def _rgb(lab: SingleArray) -> SingleArray:
    """A picture (H, W, 3) in grey levels, from CIELAB."""
    return np.asarray(cv2.cvtColor(lab.astype(np.float32), cv2.COLOR_LAB2RGB)) * np.float32(LEVELS - 1)


REINHARD = PixelTransfer(
    "reinhard",
    "Reinhard colour transfer",
    "Reinhard et al., Color Transfer between Images, 2001, in CIELAB; statistics of the backgrounds",
    transfer_colour,
)
