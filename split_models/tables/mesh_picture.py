"""Pictures of deformed meshes for people: depth as colour, slopes as shading; no graphics library is needed."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.optics.height_map import Indentation, slopes
from tactiledata.optics.surface import GelSurface
from tactiledata.optics.view import View
from tactiledata.sensors.digit import DIGIT

LIGHT = np.array([-0.5, -0.5, 0.7])
"""Direction towards the light: along columns, along rows, towards the camera."""
STEEPER = 1.5
"""Factor by which slopes are exaggerated in the shading."""
BULGE = 0.15
"""Share of the colour scale that shows gel bulging outwards."""


class MeshPictures:
    """Renderer of meshes on one surface, seen by the nominal camera.

    Parameters
    ----------
    surface : GelSurface
        Undeformed surface.
    shape : (rows, columns)
        Size of the pictures in px.
    deepest : float, m
        Indentation at the end of the colour scale.
    """

    def __init__(self, surface: GelSurface, shape: tuple[int, int], deepest: float) -> None:
        self.deepest = max(deepest, 1e-6)
        self.view = View.nominal(DIGIT, shape)
        self._drawn = Indentation(surface, self.view)

    def draw(self, displacement: NDArray[np.floating]) -> NDArray[np.uint8]:
        """A picture (rows, columns, 3), uint8, of a displacement (k, 3), m."""
        depth = self._drawn.of(displacement)
        share = BULGE + (1 - BULGE) * np.clip(depth / self.deepest, -BULGE, 1.0)
        levels = np.rint(255 * share.clip(0, 1)).astype(np.uint8)
        colour: Any = cv2.applyColorMap(levels, cv2.COLORMAP_VIRIDIS)[..., ::-1]
        slope = STEEPER * slopes(depth, self.view)
        normal = np.concatenate([slope, np.ones_like(slope[..., :1])], axis=-1)
        light = normal @ LIGHT / np.linalg.norm(normal, axis=-1) / np.linalg.norm(LIGHT)
        flat = LIGHT[2] / np.linalg.norm(LIGHT)
        return np.clip(np.rint(colour * (light / flat).clip(0.3, 1.4)[..., None]), 0, 255).astype(np.uint8)
