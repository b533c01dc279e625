"""Nine pins with round ends on a plate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.arrays import Array
from tactiledata.indenters.base import ParametricIndenter
from tactiledata.indenters.base.planar import swept_distance
from tactiledata.indenters.base.surface import circle, lofted_faces, sealed

if TYPE_CHECKING:
    import trimesh

GRID = np.array([[column, row] for row in (-1, 0, 1) for column in (-1, 0, 1)], dtype=float)
"""Places (9, 2) of the pins, in pitches."""
PIN_SECTIONS = 32
"""Segments of a full turn of a pin in the mesh; a multiple of 8, so that corners of the cells are among them."""


@dataclass(frozen=True)
class Dots(ParametricIndenter):
    """Nine pins with round ends, in a square grid of 3 x 3, on a plate: many small contacts at once.

    The origin is the tip of the middle pin. Pins have ``pin_radius`` and reach ``pin_length`` below the plate, whose
    top is at ``length``, m. Inside the body the signed distance is a bound, not exact: near the feet of the pins the
    true depth is larger.
    """

    shape = "dots"
    title = "3 x 3 round-ended pins on a plate"
    is_exact_inside = False

    pin_radius: float = 0.00075
    pitch: float = 0.0025
    pin_length: float = 0.003
    length: float = 0.006

    def _laws(self) -> tuple[tuple[bool, str], ...]:
        return (
            (2 * self.pin_radius < self.pitch, "2 * pin_radius < pitch"),
            (self.pin_radius < self.pin_length, "pin_radius < pin_length"),
            (self.pin_length + self.pin_radius <= self.length, "pin_length + pin_radius <= length"),
        )

    def signed_distance(self, points: Array) -> Array:
        # the nearest pin is the pin of the nearest cell
        places = self.pitch * np.clip(np.rint(points[:, :2] / self.pitch), -1, 1)
        shaft = np.clip(points[:, 2], self.pin_radius, self.pin_length)
        to_pin = np.linalg.norm(points - np.column_stack([places, shaft]), axis=1) - self.pin_radius
        # the plate above the pins
        beyond = np.abs(points[:, :2]) - 1.5 * self.pitch
        section = np.linalg.norm(np.maximum(beyond, 0.0), axis=1) + np.minimum(beyond.max(axis=1), 0.0)
        half = (self.length - self.pin_length) / 2
        to_plate = swept_distance(section, points[:, 2] - self.pin_length - half, half)
        return np.minimum(to_pin, to_plate)

    def mesh(self) -> trimesh.Trimesh:
        import trimesh

        cells = [self._cell().apply_translation([*(self.pitch * place), 0.0]) for place in GRID]
        under = trimesh.util.concatenate(cells)
        assert isinstance(under, trimesh.Trimesh)  # of meshes alone it is one
        under.merge_vertices(digits_vertex=9)
        # close it: walls up from the open edges, and a fan over the top; an edge that only one face has is open
        once = trimesh.grouping.group_rows(under.edges_sorted, require_count=1)
        start, end = under.edges[once].T
        n = len(under.vertices)
        vertices = np.concatenate([under.vertices, under.vertices * [1, 1, 0] + [0, 0, self.length]])
        vertices = np.concatenate([vertices, [[0.0, 0.0, self.length]]])
        walls = [np.column_stack([end, start, start + n]), np.column_stack([end, start + n, end + n])]
        top = np.column_stack([end + n, start + n, np.full(len(start), 2 * n)])
        return sealed(vertices, np.concatenate([under.faces, *walls, top]))

    def _cell(self) -> trimesh.Trimesh:
        """Mesh of one pin and of the plate's underside around it, open at the edge of the square."""
        import trimesh

        # rings of vertices from the tip up the pin, then out to the edge of the square
        polar = np.linspace(0.0, np.pi / 2, 9)[1:]
        around = circle(1.0, PIN_SECTIONS)
        radii = [*(self.pin_radius * np.sin(polar)), self.pin_radius]
        heights = [*(self.pin_radius * (1.0 - np.cos(polar))), self.pin_length]
        rings = [np.column_stack([r * around, np.full(PIN_SECTIONS, z)]) for r, z in zip(radii, heights, strict=True)]
        square = self.pitch / 2 * around / np.abs(around).max(axis=1, keepdims=True)
        rings.append(np.column_stack([square, np.full(PIN_SECTIONS, self.pin_length)]))
        vertices = np.concatenate([*rings, [[0.0, 0.0, 0.0]]])
        turn = np.arange(PIN_SECTIONS)
        tip = np.column_stack([np.roll(turn, -1), turn, np.full(PIN_SECTIONS, len(vertices) - 1)])
        faces = np.concatenate([tip, lofted_faces(len(rings), PIN_SECTIONS)])
        return trimesh.Trimesh(vertices, faces, process=False)

    def height(self, x: Array, y: Array) -> Array:
        column, row = (np.clip(np.rint(axis / self.pitch), -1, 1) * self.pitch for axis in (x, y))
        squared = self.pin_radius**2 - (x - column) ** 2 - (y - row) ** 2
        pin = self.pin_radius - np.sqrt(np.maximum(squared, 0.0))
        is_plate = np.maximum(np.abs(x), np.abs(y)) <= 1.5 * self.pitch
        return np.where(squared >= 0, pin, np.where(is_plate, self.pin_length, np.inf))
