"""A box that stands on a face."""

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
class Box(ParametricIndenter):
    """A box that stands on a face: ``width`` along x, ``breadth`` along y, ``length`` along z, m."""

    shape = "box"
    title = "box or cube on a face"

    width: float = 0.008
    breadth: float = 0.008
    length: float = 0.008

    @property
    def _corners(self) -> Array:
        """Corners (4, 2) of the section, m, counter-clockwise."""
        return np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * [self.width / 2, self.breadth / 2]

    def signed_distance(self, points: Array) -> Array:
        section = polygon_distance(points[:, :2], self._corners)
        return swept_distance(section, points[:, 2] - self.length / 2, self.length / 2)

    def mesh(self) -> trimesh.Trimesh:
        return prism_mesh(self._corners, self.length)

    def height(self, x: Array, y: Array) -> Array:
        flat = np.column_stack([np.ravel(x), np.ravel(y)])
        return np.where(polygon_distance(flat, self._corners) <= 0, 0.0, np.inf).reshape(np.shape(x))
