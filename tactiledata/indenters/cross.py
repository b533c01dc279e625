"""A flat punch with the section of a cross."""

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
class Cross(ParametricIndenter):
    """A punch with the section of a plus sign: two bars of length ``span`` and width ``bar``, m, with inner corners."""

    shape = "cross"
    title = "cross-shaped punch"

    span: float = 0.010
    bar: float = 0.003
    length: float = 0.010

    def _laws(self) -> tuple[tuple[bool, str], ...]:
        return ((self.bar < self.span, "bar < span"),)

    @property
    def _corners(self) -> Array:
        """Corners (12, 2) of the section, m, counter-clockwise."""
        s, b = self.span / 2, self.bar / 2
        quarter = np.array([[s, -b], [s, b], [b, b]])
        turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
        return np.concatenate([quarter @ np.linalg.matrix_power(turn, k) for k in range(4)])

    def signed_distance(self, points: Array) -> Array:
        section = polygon_distance(points[:, :2], self._corners)
        return swept_distance(section, points[:, 2] - self.length / 2, self.length / 2)

    def mesh(self) -> trimesh.Trimesh:
        return prism_mesh(self._corners, self.length)

    def height(self, x: Array, y: Array) -> Array:
        flat = np.column_stack([np.ravel(x), np.ravel(y)])
        return np.where(polygon_distance(flat, self._corners) <= 0, 0.0, np.inf).reshape(np.shape(x))
