"""A cylinder with a shallow dome at its end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.arrays import Array
from tactiledata.indenters.base import ParametricIndenter
from tactiledata.indenters.base.planar import radius_of
from tactiledata.indenters.base.surface import revolved_mesh

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True)
class Dome(ParametricIndenter):
    """A cylinder of ``radius`` that ends in a spherical cap of ``curvature_radius``, m.

    It has the curvature of a large ball, and fits the gel.
    """

    shape = "dome"
    title = "shallow spherical cap on a cylinder"

    curvature_radius: float = 0.010
    radius: float = 0.005
    length: float = 0.010

    def _laws(self) -> tuple[tuple[bool, str], ...]:
        return (
            (self.radius <= self.curvature_radius, "radius <= curvature_radius"),
            (self.radius > self.curvature_radius or self.length > self._cap, "length above the height of the cap"),
        )

    @property
    def _cap(self) -> float:
        """Height of the cap, m."""
        return self.curvature_radius - float(np.sqrt(self.curvature_radius**2 - self.radius**2))

    def signed_distance(self, points: Array) -> Array:
        across, z = radius_of(points), points[:, 2]
        # boundary pieces of the half plane (radius, z): cap, wall, top; each nearest point is clamped to its piece
        widest = np.arcsin(self.radius / self.curvature_radius)
        polar = np.minimum(np.arctan2(across, self.curvature_radius - z), widest)
        to_cap = np.hypot(
            across - self.curvature_radius * np.sin(polar), z - self.curvature_radius * (1 - np.cos(polar))
        )
        to_wall = np.hypot(across - self.radius, z - np.clip(z, self._cap, self.length))
        to_top = np.hypot(across - np.minimum(across, self.radius), z - self.length)
        in_ball = np.hypot(across, z - self.curvature_radius) <= self.curvature_radius
        is_inside = (across <= self.radius) & (z <= self.length) & (in_ball | (z >= self._cap))
        return np.where(is_inside, -1.0, 1.0) * np.minimum(np.minimum(to_cap, to_wall), to_top)

    def mesh(self) -> trimesh.Trimesh:
        polar = np.linspace(0.0, np.arcsin(self.radius / self.curvature_radius), 33)
        cap = self.curvature_radius * np.stack([np.sin(polar), 1.0 - np.cos(polar)], axis=1)
        return revolved_mesh(np.concatenate([cap, [[self.radius, self.length], [0.0, self.length]]]))

    def height(self, x: Array, y: Array) -> Array:
        across = np.hypot(x, y)
        cap = self.curvature_radius - np.sqrt(np.maximum(self.curvature_radius**2 - across**2, 0.0))
        return np.where(across <= self.radius, cap, np.inf)
