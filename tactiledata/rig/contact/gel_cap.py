"""The outer surface of a domed gel: a spherical cap over the middle of the pad."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import RealArray

STEEPEST = 0.9
"""Largest r² / R² at which the surface still falls; beyond it the height stays."""


@dataclass(frozen=True)
class Cap:
    """A spherical cap: at a distance r from the middle it lies lower by R - sqrt(R² - r²).

    Parameters
    ----------
    curvature : 1/m
        Reciprocal of the sphere's radius R; 0 is flat.
    """

    curvature: float = 0.0

    def fall(self, x: RealArray | float, y: RealArray | float) -> RealArray:
        """Return the depth, m, of the surface below its middle at places x, y, m, of one shape."""
        if self.curvature == 0:
            return np.zeros(np.broadcast(x, y).shape)
        return np.asarray(1 / self.curvature - self._height(x, y))

    def fall_from(self, place: tuple[float, float], x: RealArray | float, y: RealArray | float) -> RealArray:
        """Return the depth, m, of the surface at x, y below its height at another place.

        Parameters
        ----------
        place : (2,), m
            The place to compare with.
        x, y : arrays or numbers of one shape, m
            Places on the gel.
        """
        return self.fall(x, y) - self.fall(*place)

    def downhill(self, place: tuple[float, float]) -> RealArray:
        """Return the slope (2,), m/m, by which the surface falls along x and y at a place (2,), m."""
        if self.curvature == 0:
            return np.zeros(2)
        return np.asarray(place) / self._height(*place)

    def _height(self, x: RealArray | float, y: RealArray | float) -> RealArray:
        """Return the height of the surface over the sphere's centre, m."""
        radius = 1 / self.curvature
        return np.sqrt(radius**2 - np.minimum(np.square(x) + np.square(y), STEEPEST * radius**2))
