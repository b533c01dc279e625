"""What a baseline is calibrated on: pictures of one unit beside the meshes that were simulated for them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.optics.height_map import Indentation, slopes
from tactiledata.optics.taxim_calibration import Press
from tactiledata.optics.view import View


@dataclass(frozen=True)
class TouchedPicture:
    """A frame.

    Parameters
    ----------
    picture, background : (rows, columns, 3), uint8 RGB
    displacement : (k, 3), metres
    """

    picture: NDArray[np.uint8]
    background: NDArray[np.uint8]
    displacement: NDArray[np.float32]


def press_of(touch: TouchedPicture, indentation: NDArray[np.float32], view: View) -> Press:
    """The frame as a press of known slopes, everywhere on the picture."""
    change = touch.picture.astype(np.float32) - touch.background
    return Press(change, slopes(indentation, view), np.ones(indentation.shape, bool))


def smooth_indentation(drawn: Indentation, displacement: Any, smoothing: float) -> NDArray[np.float32]:
    """An indentation (rows, columns), metres, without the facets of its mesh.

    Parameters
    ----------
    drawn : Indentation
    displacement : (k, 3), metres
    smoothing : metres
        Standard deviation of the blur; 0 leaves the facets.
    """
    depth = drawn.of(displacement)
    if smoothing <= 0:
        return depth
    across, down = drawn.view.pitches
    blurred: Any = cv2.GaussianBlur(depth, (0, 0), sigmaX=smoothing / across, sigmaY=smoothing / down)
    return blurred
