"""An indenter of one's own: a pin with a round tip."""

from dataclasses import dataclass

import numpy as np
import trimesh

from tactiledata.indenters.base import ParametricIndenter


@dataclass(frozen=True)
class Capsule(ParametricIndenter):
    """A cylinder with half a ball at both ends; touches with the ball."""

    shape = "capsule"
    title = "pin with a round tip"

    radius: float = 0.002
    length: float = 0.006

    def signed_distance(self, points):
        """Distance to the axis' segment, less the radius."""
        along = np.clip(points[:, 2], self.radius, self.radius + self.length)
        axis = np.stack([np.zeros(len(points)), np.zeros(len(points)), along], axis=1)
        return np.linalg.norm(points - axis, axis=1) - self.radius

    def mesh(self):
        """The surface; the lower end at z = 0."""
        angle = np.linspace(-np.pi / 2, np.pi / 2, 65)
        level = self.radius + np.where(angle > 0, self.length, 0) + self.radius * np.sin(angle)
        outline = np.stack([self.radius * np.cos(angle), level], axis=1)
        outline[[0, -1], 0] = 0  # the poles lie on the axis, not a rounding error beside it
        # trimesh merges points closer than 1e-8, which in metres tears small bodies: turned in millimetres
        return trimesh.creation.revolve(1000 * outline, sections=64).apply_scale(1e-3)

    def height(self, x, y):
        """The lower half ball."""
        squared = self.radius**2 - x**2 - y**2
        return np.where(squared >= 0, self.radius - np.sqrt(np.maximum(squared, 0)), np.inf)
