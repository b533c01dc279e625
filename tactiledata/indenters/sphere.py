"""A ball, which touches in one point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.arrays import Array
from tactiledata.indenters.base import ParametricIndenter

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True)
class Sphere(ParametricIndenter):
    """A ball that touches in one point: the reference shape, for which Hertz solved the contact."""

    shape = "sphere"
    title = "ball"

    radius: float = 0.004

    def signed_distance(self, points: Array) -> Array:
        return np.linalg.norm(points - [0.0, 0.0, self.radius], axis=1) - self.radius

    def mesh(self) -> trimesh.Trimesh:
        import trimesh

        ball = trimesh.creation.icosphere(subdivisions=4, radius=self.radius)
        ball.apply_translation([0.0, 0.0, self.radius])
        return ball

    def height(self, x: Array, y: Array) -> Array:
        squared = self.radius**2 - x**2 - y**2
        return np.where(squared >= 0, self.radius - np.sqrt(np.maximum(squared, 0.0)), np.inf)
