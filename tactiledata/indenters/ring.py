"""A hollow punch: a tube on its end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.arrays import Array
from tactiledata.indenters.base import ParametricIndenter
from tactiledata.indenters.base.planar import radius_of, swept_distance
from tactiledata.indenters.base.surface import revolved_mesh

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True)
class Ring(ParametricIndenter):
    """A tube that stands on its end; it touches in a flat annulus around an empty middle."""

    shape = "ring"
    title = "hollow punch: a tube on its end"

    outer_radius: float = 0.004
    inner_radius: float = 0.0025
    length: float = 0.010

    def _laws(self) -> tuple[tuple[bool, str], ...]:
        return ((self.inner_radius < self.outer_radius, "inner_radius < outer_radius"),)

    def _section(self, across: Array) -> Array:
        """Signed distance, m, to the annulus at distances from the axis, m."""
        middle = (self.outer_radius + self.inner_radius) / 2
        return np.abs(across - middle) - (self.outer_radius - self.inner_radius) / 2

    def signed_distance(self, points: Array) -> Array:
        return swept_distance(self._section(radius_of(points)), points[:, 2] - self.length / 2, self.length / 2)

    def mesh(self) -> trimesh.Trimesh:
        inner, outer, top = self.inner_radius, self.outer_radius, self.length
        return revolved_mesh([[inner, 0.0], [outer, 0.0], [outer, top], [inner, top]], is_closed=True)

    def height(self, x: Array, y: Array) -> Array:
        return np.where(self._section(np.hypot(x, y)) <= 0, 0.0, np.inf)
