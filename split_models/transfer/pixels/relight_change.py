"""The change that a touch makes, freed of camera noise and put into the light of another sensor.

The constants were chosen on contacts and backgrounds that the reported figures leave out: decision 0042.
"""

from __future__ import annotations

import cv2
import numpy as np

from tactiledata.arrays import SingleArray

LIGHT_BLUR = 1 / 30
"""Width of the blur of both backgrounds before their ratio, as a share of a picture's width: 8 px on a DIGIT. Light
varies slowly over the gel; dust and camera noise do not."""
LEAST_LIGHT = 32.0
"""Grey levels that are added to both backgrounds before their ratio, so that no dark place of the source makes noise
bright."""
LEVEL_SPAN = 0.08
"""Largest relative change of a touch's strength by the light of the target: a target that is darker as a whole does not
make the touch vanish, one that is brighter does not exaggerate it."""
GRAIN = 1 / 80
"""Width of the neighbourhood in which noise is told from a touch, as a share of a picture's width: 3 px on a DIGIT."""
NOISE_SHARE = 16.0
"""Variance, in variances of the camera's noise, up to which a neighbourhood's detail counts as noise."""
SECOND_DIFFERENCE = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32) / 6
"""Filter that keeps the standard deviation of independent noise and removes what is smooth in rows or in columns."""


def relit_change(changes: SingleArray, source_background: SingleArray, target_background: SingleArray) -> SingleArray:
    """Changes as the light of the target would show them, without the camera's noise.

    Parameters
    ----------
    changes : (n, H, W, 3) float32, grey levels
        Pictures of the source minus its background.
    source_background, target_background : (H, W, 3) float32, grey levels
        Source and target without contact.
    """
    gain = light_ratio(source_background, target_background)
    relit = np.empty_like(changes, dtype=np.float32)
    for row, change in enumerate(changes):
        clean = without_noise(change)
        lit = clean * gain
        before, after = (float(np.sqrt(np.square(one, dtype=np.float64).sum())) for one in (clean, lit))
        if before > 0.0:
            level = after / before
            lit *= np.float32(np.clip(level, 1 - LEVEL_SPAN, 1 + LEVEL_SPAN) / level)
        relit[row] = lit
    return relit


def light_ratio(source_background: SingleArray, target_background: SingleArray) -> SingleArray:
    """Ratio (H, W, 3) of the target's light to the source's, at each place and in each channel.

    Parameters
    ----------
    source_background, target_background : (H, W, 3) float32, grey levels
        Source and target without contact.
    """
    sigma = LIGHT_BLUR * source_background.shape[1]
    target, source = (cv2.GaussianBlur(one, (0, 0), sigma) for one in (target_background, source_background))
    return np.asarray((target + LEAST_LIGHT) / (source + LEAST_LIGHT), np.float32)


def without_noise(change: SingleArray) -> SingleArray:
    """A change (H, W, 3), grey levels, whose detail is shrunk where it is no stronger than the camera's noise.

    Each neighbourhood keeps its mean and the share of its detail that exceeds the noise (a Wiener filter with local
    variances); edges of a touch stay sharp. A change without noise stays as it is.

    Source
    ------
    Lee, Digital Image Enhancement and Noise Filtering by Use of Local Statistics, IEEE TPAMI 1980
    """
    noise = NOISE_SHARE * noise_of(change) ** 2
    if noise == 0.0:
        return change
    sigma = max(GRAIN * change.shape[1], 0.5)
    mean = cv2.GaussianBlur(change, (0, 0), sigma)
    variance = np.maximum(cv2.GaussianBlur(change * change, (0, 0), sigma) - mean * mean, 0.0).mean(-1, keepdims=True)
    share = np.maximum(variance - noise, 0.0) / np.maximum(variance, noise)
    return np.asarray(mean + share * (change - mean), np.float32)


def noise_of(change: SingleArray) -> float:
    """Standard deviation, grey levels, of the camera's noise in a change (H, W, 3).

    It is that of second differences along rows and columns, which a smooth touch leaves at zero.
    """
    fine = cv2.filter2D(change, -1, SECOND_DIFFERENCE)
    return float(np.abs(fine).mean(dtype=np.float64) * np.sqrt(np.pi / 2))
