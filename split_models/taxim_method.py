"""Taxim as a baseline: a mesh's height map, its slopes, the polynomial table, shadows, and the background."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from split_models.touched_pictures import TouchedPicture, press_of, smooth_indentation
from tactiledata.errors import UsageError
from tactiledata.optics.height_map import Indentation, slopes
from tactiledata.optics.shadows import Shadows, fit_shadows, light_azimuths
from tactiledata.optics.surface import GelSurface
from tactiledata.optics.taxim import TaximTable, published_digit_table
from tactiledata.optics.taxim_calibration import calibrate
from tactiledata.optics.view import View
from tactiledata.sensors.base import Sensor
from tactiledata.sensors.digit import DIGIT

SMOOTHING = 2e-4
"""m: standard deviation of the blur that takes the facets out of a height map."""


@dataclass(frozen=True)
class TaximMethod:
    """Pictures of deformed meshes by Taxim's table.

    Parameters
    ----------
    name : str
    surface : GelSurface
        The mesh that displacements belong to.
    view : View
        What the camera sees; of another size than the background, it is scaled.
    table : TaximTable
    shadows : Shadows, optional
    smoothing : metres
    """

    name: str
    surface: GelSurface
    view: View
    table: TaximTable
    shadows: Shadows | None = None
    smoothing: float = SMOOTHING

    @classmethod
    def published(cls, surface: GelSurface, sensor: Sensor = DIGIT, path: Path | None = None) -> TaximMethod:
        """With the published DIGIT table and the nominal camera: nothing of the unit at hand but its background."""
        return cls("taxim_published", surface, View.nominal(sensor), published_digit_table(path))

    @classmethod
    def fit(cls, surface: GelSurface, view: View, touches: Iterable[TouchedPicture], origin: str) -> TaximMethod:
        """Calibrated on one unit's touches of known meshes, seen through its registered camera.

        Raises
        ------
        UsageError
            No touch shows a contact.
        """
        seen = list(touches)
        if not seen:
            raise UsageError("no touch to calibrate Taxim on", "pictures with their meshes", "")
        view_here = view.scaled(seen[0].picture.shape[:2])
        drawn = Indentation(surface, view_here)
        depths = [smooth_indentation(drawn, touch.displacement, SMOOTHING) for touch in seen]
        presses = [press_of(touch, depth, view_here) for touch, depth in zip(seen, depths, strict=True)]
        table = calibrate(presses, origin)
        residuals = [press.change - table.change(press.slopes) for press in presses]
        backgrounds = [touch.background for touch in seen]
        shadows = fit_shadows(residuals, backgrounds, depths, view_here, light_azimuths(table))
        return cls("taxim_calibrated", surface, view, table, shadows)

    def predict(self, displacements: Any, background: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Pictures (n, rows, columns, 3) uint8 of displacements (n, k, 3), m, on a background (rows, columns, 3)."""
        view = self.view.scaled(background.shape[:2])
        drawn = Indentation(self.surface, view)
        base = background.astype(np.float32)
        pictures = np.empty((len(displacements), *background.shape), np.uint8)
        for row, displacement in enumerate(displacements):
            depth = smooth_indentation(drawn, displacement, self.smoothing)
            picture = base + self.table.change(slopes(depth, view))
            if self.shadows is not None:
                picture -= base * self.shadows.darkening(depth, view)
            pictures[row] = cv2.add(picture, 0.0, dtype=cv2.CV_8U)
        return pictures
