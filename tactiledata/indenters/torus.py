"""A ring of round section that lies flat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.arrays import Array
from tactiledata.indenters.base import ParametricIndenter
from tactiledata.indenters.base.planar import radius_of
from tactiledata.indenters.base.surface import SECTIONS, circle, revolved_mesh

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True)
class Torus(ParametricIndenter):
    """A ring of round section that lies flat; it touches along a circle of ``ring_radius``, m, without edges."""

    shape = "torus"
    title = "ring of round section"

    ring_radius: float = 0.004
    tube_radius: float = 0.0015

    def _laws(self) -> tuple[tuple[bool, str], ...]:
        return ((self.tube_radius < self.ring_radius, "tube_radius < ring_radius"),)

    def signed_distance(self, points: Array) -> Array:
        return np.hypot(radius_of(points) - self.ring_radius, points[:, 2] - self.tube_radius) - self.tube_radius

    def mesh(self) -> trimesh.Trimesh:
        centre = np.array([self.ring_radius, self.tube_radius])
        return revolved_mesh(centre + circle(self.tube_radius, SECTIONS // 2), is_closed=True)

    def height(self, x: Array, y: Array) -> Array:
        squared = self.tube_radius**2 - (np.hypot(x, y) - self.ring_radius) ** 2
        return np.where(squared >= 0, self.tube_radius - np.sqrt(np.maximum(squared, 0.0)), np.inf)
