"""The outer surface of a domed gel: a cap of a ball over the middle of the pad."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import RealArray

STEEPEST = 0.9
"""Square of the ball's radius beyond which the surface falls no further, relative."""


@dataclass(frozen=True)
class Cap:
    """A surface that falls by R - sqrt(R² - r²) at r from the middle.

    Parameters
    ----------
    curvature : 1/m
        1 / R; 0 is flat.
    """

    curvature: float = 0.0

    def fall(self, x: RealArray | float, y: RealArray | float) -> RealArray:
        """Metres below the middle at places x, y, m, of one shape."""
        if self.curvature == 0:
            return np.zeros(np.broadcast(x, y).shape)
        return np.asarray(1 / self.curvature - self._height(x, y))

    def fall_from(self, place: tuple[float, float], x: RealArray | float, y: RealArray | float) -> RealArray:
        """Metres below the surface at ``place`` (2,), m."""
        return self.fall(x, y) - self.fall(*place)

    def downhill(self, place: tuple[float, float]) -> RealArray:
        """How much the surface falls along x and y (2,) at a place (2,), m; m/m."""
        if self.curvature == 0:
            return np.zeros(2)
        return np.asarray(place) / self._height(*place)

    def _height(self, x: RealArray | float, y: RealArray | float) -> RealArray:
        """Over the ball's centre, m."""
        radius = 1 / self.curvature
        return np.sqrt(radius**2 - np.minimum(np.square(x) + np.square(y), STEEPEST * radius**2))
