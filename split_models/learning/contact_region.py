"""Masks of the touch in a picture: pixels that differ from the sensor's background."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

THRESHOLD = 6.0
"""Least difference in grey levels that counts as a touch; blurred camera noise and JPEG artefacts stay below it."""
BLUR = 0.0125
"""Standard deviation of the blur, as a share of the picture's width."""


def contact_region(pictures: NDArray[np.uint8], background: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Masks (n, h, w) of the touch in pictures (n, h, w, 3) of a sensor with a background (h, w, 3).

    Only the recorded pictures decide: no camera needs registration, and no method influences where it is scored.
    """
    sigma = BLUR * pictures.shape[2]
    masks = np.empty(pictures.shape[:3], bool)
    for row, picture in enumerate(pictures):
        difference = np.abs(picture.astype(np.float32) - background).max(axis=-1)
        masks[row] = cv2.GaussianBlur(difference, (0, 0), sigma) > THRESHOLD
    return masks
