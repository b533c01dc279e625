"""A cylinder that lies on its side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.arrays import Array
from tactiledata.indenters.base import ParametricIndenter
from tactiledata.indenters.base.planar import swept_distance
from tactiledata.indenters.base.surface import circle, prism_mesh

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True)
class CylinderSide(ParametricIndenter):
    """A cylinder that lies on its side, axis along x, ``width`` long; it touches along a line."""

    shape = "cylinder_side"
    title = "lying cylinder, axis along x"

    radius: float = 0.003
    width: float = 0.010

    def signed_distance(self, points: Array) -> Array:
        section = np.hypot(points[:, 1], points[:, 2] - self.radius) - self.radius
        return swept_distance(section, points[:, 0], self.width / 2)

    def mesh(self) -> trimesh.Trimesh:
        rod = prism_mesh(circle(self.radius), self.width)
        # the prism stands on its section: lay it down along x
        across, up, along = rod.vertices.T
        rod.vertices = np.column_stack([along - self.width / 2, across, up + self.radius])
        return rod

    def height(self, x: Array, y: Array) -> Array:
        squared = self.radius**2 - y**2
        lower = self.radius - np.sqrt(np.maximum(squared, 0.0))
        return np.where((squared >= 0) & (np.abs(x) <= self.width / 2), lower, np.inf)
