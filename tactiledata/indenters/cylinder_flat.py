"""A flat punch: a cylinder on its end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.arrays import Array
from tactiledata.indenters.base import ParametricIndenter
from tactiledata.indenters.base.planar import radius_of, swept_distance
from tactiledata.indenters.base.surface import circle, prism_mesh

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True)
class CylinderFlat(ParametricIndenter):
    """A cylinder that stands on its flat end: the flat punch, with a sharp rim."""

    shape = "cylinder_flat"
    title = "flat punch: a cylinder on its end"

    radius: float = 0.003
    length: float = 0.010

    def signed_distance(self, points: Array) -> Array:
        return swept_distance(radius_of(points) - self.radius, points[:, 2] - self.length / 2, self.length / 2)

    def mesh(self) -> trimesh.Trimesh:
        return prism_mesh(circle(self.radius), self.length)

    def height(self, x: Array, y: Array) -> Array:
        return np.where(np.hypot(x, y) <= self.radius, 0.0, np.inf)
