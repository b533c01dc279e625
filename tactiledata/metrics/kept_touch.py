"""How much of a touch a changed picture keeps: strength, correlation and mask overlap of what the touch changes.

The touch is the change of a picture against its sensor's picture without contact. A picture of another sensor has
another background; what the touch changes there is compared with what it changed in the recorded picture.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import PictureArray, SingleArray
from tactiledata.errors import UsageError
from tactiledata.metrics.base import Score, Values, images, metric
from tactiledata.sensors.image_checks import CONTACT_BLUR

TOUCHED = 8.0
"""Least change, grey levels, that counts as touched; the change is the norm over the channels after a blur."""


def change_of(pictures: PictureArray, background: PictureArray) -> SingleArray:
    """Return the change (n, H, W, 3), grey levels, of pictures against a background.

    Parameters
    ----------
    pictures : (n, H, W, 3) uint8
        Pictures of one sensor.
    background : (H, W, 3) uint8
        The same sensor without contact.

    Raises
    ------
    UsageError
        Pictures and background differ in size.
    """
    batch = images(pictures, "pictures")
    if background.shape != batch.shape[1:]:
        raise UsageError(
            f"pictures of shape {batch.shape[1:]} with a background of {background.shape}", "one size for both", ""
        )
    return batch.astype(np.float32) - background


def touched(changes: SingleArray) -> NDArray[np.bool_]:
    """Return masks (n, H, W) of where changes (n, H, W, 3), grey levels, show a touch.

    The change is blurred with its sign, so that camera noise cancels and is no touch.
    """
    sigma = CONTACT_BLUR * max(changes.shape[1:3])
    masks = np.empty(changes.shape[:3], bool)
    for row, change in enumerate(changes):
        masks[row] = _magnitudes(cv2.GaussianBlur(change, (0, 0), sigma)) >= TOUCHED
    return masks


def strength(changes: Any, recorded: Any) -> Values:
    """Return the strength (n,) that is kept: mean magnitude of a change over that of the recorded one.

    Both means are over the pixels that the recorded change touches. 1 is kept, 0 is lost, and above 1 the touch is
    stronger than it was recorded. A change without a touch is NaN.

    Parameters
    ----------
    changes, recorded : (n, H, W, 3) grey levels
        Changes, pair by pair, as `change_of` gives them.
    """
    ours, theirs = _pairs(changes, recorded)
    values = np.full(len(ours), np.nan)
    for row, (change, true, mask) in enumerate(zip(ours, theirs, touched(theirs), strict=True)):
        if mask.any():
            means = [_magnitudes(one[mask]).mean(dtype=np.float64) for one in (change, true)]
            values[row] = means[0] / means[1]
    return values


def correlation(changes: Any, recorded: Any) -> Values:
    """Return Pearson's correlation (n,) of the magnitudes of two changes over the frame.

    The colours of the change play no part, since they follow the light of the sensor. A change that is the same at
    every pixel has correlation 0: it shows nothing of the touch. A recorded change without a touch is NaN.

    Parameters
    ----------
    changes, recorded : (n, H, W, 3) grey levels
        Changes, pair by pair, as `change_of` gives them.
    """
    ours, theirs = _pairs(changes, recorded)
    values = np.full(len(ours), np.nan)
    for row, (change, true, mask) in enumerate(zip(ours, theirs, touched(theirs), strict=True)):
        if mask.any():
            one, other = (_magnitudes(part).ravel().astype(np.float64) for part in (change, true))
            spread = one.std() * other.std()
            product = ((one - one.mean()) * (other - other.mean())).mean()
            values[row] = product / spread if spread > 0 else 0.0
    return values


def overlap(changes: Any, recorded: Any) -> Values:
    """Return the intersection over union (n,) of where two changes show a touch.

    A recorded change without a touch is NaN.

    Parameters
    ----------
    changes, recorded : (n, H, W, 3) grey levels
        Changes, pair by pair, as `change_of` gives them.
    """
    ours, theirs = (touched(batch) for batch in _pairs(changes, recorded))
    either = (ours | theirs).sum(axis=(1, 2))
    share = (ours & theirs).sum(axis=(1, 2)) / np.maximum(either, 1)
    return np.where(theirs.any(axis=(1, 2)), share, np.nan)


def _magnitudes(changes: SingleArray) -> SingleArray:
    """Return the norm (...,) over the channels of changes (..., 3), grey levels."""
    squares = changes * changes
    # to the bit np.linalg.norm, which takes eight times as long over an axis of three
    return np.sqrt(squares[..., 0] + squares[..., 1] + squares[..., 2])


def _pairs(changes: Any, recorded: Any) -> tuple[SingleArray, SingleArray]:
    """Return two batches of changes as arrays, or refuse them."""
    ours, theirs = np.asarray(changes, np.float32), np.asarray(recorded, np.float32)
    if ours.shape != theirs.shape or ours.ndim != 4 or ours.shape[3] != 3:
        raise UsageError(f"changes of shape {ours.shape} beside {theirs.shape}", "both (n, H, W, 3)", "")
    return ours, theirs


KEPT_TOUCH = metric(
    "kept_touch",
    "how much of a touch a changed picture keeps",
    "changes",
    [
        Score("strength_kept", "strength kept", "", "nearest", 1.0, strength),
        Score("change_correlation", "correlation of the change", "", "higher", 1.0, correlation),
        Score("mask_overlap", "mask overlap", "", "higher", 1.0, overlap),
    ],
)
