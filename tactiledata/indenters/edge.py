"""A wedge with a rounded edge, which points down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.arrays import Array
from tactiledata.indenters.base import ParametricIndenter
from tactiledata.indenters.base.planar import (
    polygon_distance,
    rounded_wedge,
    rounded_wedge_height,
    rounded_wedge_outline,
    swept_distance,
)
from tactiledata.indenters.base.surface import prism_mesh

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True)
class Edge(ParametricIndenter):
    """A wedge whose edge points down and runs along x, ``width`` long, with flat ends.

    Its three edges are rounded with ``edge_radius``, m; ``half_angle`` is that between plane of symmetry and flank,
    rad; ``length`` is the height, m.
    """

    shape = "edge"
    title = "wedge with a rounded edge"

    half_angle: float = 0.6
    edge_radius: float = 0.0003
    width: float = 0.010
    length: float = 0.006

    def _laws(self) -> tuple[tuple[bool, str], ...]:
        return (
            (self.half_angle < np.pi / 2, "half_angle < pi / 2"),
            (2 * self.edge_radius < self.length, "2 * edge_radius < length"),
        )

    def signed_distance(self, points: Array) -> Array:
        core, _ = rounded_wedge(self.half_angle, self.edge_radius, self.length)
        section = polygon_distance(points[:, 1:], core) - self.edge_radius
        return swept_distance(section, points[:, 0], self.width / 2)

    def mesh(self) -> trimesh.Trimesh:
        right = rounded_wedge_outline(self.half_angle, self.edge_radius, self.length, arc_points=17)
        outline = np.concatenate([right, (right[-2:0:-1]) * [-1.0, 1.0]])
        middle = [0.0, self.length / 2]
        wedge = prism_mesh(outline - middle, self.width)
        # the prism stands on its section; lay it down: section across y and z, sweep along x
        across, up, along = wedge.vertices.T
        wedge.vertices = np.column_stack([along - self.width / 2, across, up + self.length / 2])
        return wedge

    def height(self, x: Array, y: Array) -> Array:
        lower = rounded_wedge_height(np.abs(y), self.half_angle, self.edge_radius, self.length)
        return np.where(np.abs(x) <= self.width / 2, lower, np.inf)
