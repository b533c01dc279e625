"""A hexagonal prism on its end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.arrays import Array
from tactiledata.indenters.base import ParametricIndenter
from tactiledata.indenters.base.planar import polygon_distance, swept_distance
from tactiledata.indenters.base.surface import prism_mesh

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True)
class Hexagon(ParametricIndenter):
    """A hexagonal prism on its end, with flats towards +x and -x ``across_flats`` apart, m: the end of a hex key."""

    shape = "hexagon"
    title = "hexagonal prism on its end"

    across_flats: float = 0.008
    length: float = 0.010

    @property
    def _corners(self) -> Array:
        """Corners (6, 2) of the section, m, counter-clockwise."""
        angles = np.pi / 6 + np.pi / 3 * np.arange(6)
        return self.across_flats / np.sqrt(3) * np.stack([np.cos(angles), np.sin(angles)], axis=1)

    def signed_distance(self, points: Array) -> Array:
        section = polygon_distance(points[:, :2], self._corners)
        return swept_distance(section, points[:, 2] - self.length / 2, self.length / 2)

    def mesh(self) -> trimesh.Trimesh:
        return prism_mesh(self._corners, self.length)

    def height(self, x: Array, y: Array) -> Array:
        flat = np.column_stack([np.ravel(x), np.ravel(y)])
        return np.where(polygon_distance(flat, self._corners) <= 0, 0.0, np.inf).reshape(np.shape(x))
