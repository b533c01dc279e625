"""A four-sided pyramid, tip down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.arrays import Array
from tactiledata.indenters.base import ParametricIndenter

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True)
class Pyramid(ParametricIndenter):
    """A four-sided pyramid, sharp tip down; its base of ``width`` x ``width`` lies at z = ``length``, m."""

    shape = "pyramid"
    title = "four-sided pyramid, tip down"

    width: float = 0.010
    length: float = 0.006

    def signed_distance(self, points: Array) -> Array:
        import trimesh

        # in units of half the width: closest_point compares products of four lengths with an absolute tolerance
        half, top = self.width / 2, 2 * self.length / self.width
        # the body has eight mirror images of one wedge: only the flank towards +x and the base can be nearest there
        folded = np.abs(points[:, :2]) / half
        across, aside, z = folded.max(axis=1), folded.min(axis=1), points[:, 2] / half
        flank = np.array([[0.0, 0.0, 0.0], [1.0, -1.0, top], [1.0, 1.0, top]])
        here = np.column_stack([across, aside, z])
        nearest = trimesh.triangles.closest_point(np.broadcast_to(flank, (len(here), 3, 3)), here)
        to_flank = np.linalg.norm(here - nearest, axis=1)
        beyond = np.hypot(np.maximum(across - 1.0, 0.0), np.maximum(aside - 1.0, 0.0))
        to_base = np.hypot(beyond, z - top)
        is_inside = (z <= top) & (z >= across * top)
        return np.where(is_inside, -half, half) * np.minimum(to_flank, to_base)

    def mesh(self) -> trimesh.Trimesh:
        import trimesh

        half = self.width / 2
        base = [[half, half], [-half, half], [-half, -half], [half, -half]]
        vertices = np.array([[0.0, 0.0, 0.0], *([*corner, self.length] for corner in base)])
        faces = [[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 1, 4], [1, 2, 3], [1, 3, 4]]
        return trimesh.Trimesh(vertices, faces, process=False)

    def height(self, x: Array, y: Array) -> Array:
        across = np.maximum(np.abs(x), np.abs(y))
        return np.where(across <= self.width / 2, across * 2 * self.length / self.width, np.inf)
