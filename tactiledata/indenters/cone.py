"""A cone with a rounded tip, which points down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.arrays import Array
from tactiledata.indenters.base import ParametricIndenter
from tactiledata.indenters.base.planar import (
    polygon_distance,
    radius_of,
    rounded_wedge,
    rounded_wedge_height,
    rounded_wedge_outline,
)
from tactiledata.indenters.base.surface import revolved_mesh

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True)
class Cone(ParametricIndenter):
    """A cone, tip down, whose tip and upper rim are rounded with ``tip_radius``, as in every print.

    ``half_angle`` is that between axis and flank, rad; ``length`` is the height, m.
    """

    shape = "cone"
    title = "cone with a rounded tip"

    half_angle: float = 0.7
    tip_radius: float = 0.0005
    length: float = 0.008

    def _laws(self) -> tuple[tuple[bool, str], ...]:
        return (
            (self.half_angle < np.pi / 2, "half_angle < pi / 2"),
            (2 * self.tip_radius < self.length, "2 * tip_radius < length"),
        )

    def signed_distance(self, points: Array) -> Array:
        core, _ = rounded_wedge(self.half_angle, self.tip_radius, self.length)
        return polygon_distance(np.column_stack([radius_of(points), points[:, 2]]), core) - self.tip_radius

    def mesh(self) -> trimesh.Trimesh:
        return revolved_mesh(rounded_wedge_outline(self.half_angle, self.tip_radius, self.length, arc_points=17))

    def height(self, x: Array, y: Array) -> Array:
        return rounded_wedge_height(np.hypot(x, y), self.half_angle, self.tip_radius, self.length)
