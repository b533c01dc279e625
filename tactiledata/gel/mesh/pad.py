"""The pad as a finite-element mesh: nodes, cells, the bonded base and the surface that is touched."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array, Indices

CellKind = Literal["hexahedron8", "tetrahedron10"]


@dataclass(frozen=True)
class PadMesh:
    """Undeformed pad in the gel frame: the middle of its outer surface is near z = 0, the base below it.

    Parameters
    ----------
    name : str
        Name for users and files, for example ``"digit-low"``.
    kind : "hexahedron8" or "tetrahedron10"
        Type of all cells.
    vertices : (v, 3) m
        All nodes. The order never changes: frames and sensors that share the mesh share it.
    cells : (c, 8) or (c, 10)
        Node numbers; corners in the usual order, tetrahedra followed by their six edge nodes 01, 12, 20, 03, 13, 23.
    base : (b,)
        Nodes bonded to the rigid backing.
    faces : (f, 4) or (f, 6)
        The outer surface as faces of cells, outward; six-node triangles with edge nodes 01, 12, 20.
    """

    name: str
    kind: CellKind
    vertices: Array
    cells: Indices
    base: Indices
    faces: Indices

    @cached_property
    def surface(self) -> Indices:
        """Numbers (s,) of the nodes of the outer surface, ascending."""
        return np.unique(self.faces)

    @cached_property
    def free(self) -> Indices:
        """Degrees of freedom (3 v - 3 b,) that are not held, ascending: 3 * node + axis."""
        is_held = np.zeros(len(self.vertices), dtype=bool)
        is_held[self.base] = True
        return np.flatnonzero(np.repeat(~is_held, 3))

    @cached_property
    def triangles(self) -> Indices:
        """Triangles (t, 3) of the outer surface's corner nodes, outward, for pictures and files."""
        if self.kind == "hexahedron8":
            return np.concatenate([self.faces[:, [0, 1, 2]], self.faces[:, [0, 2, 3]]])
        return self.faces[:, :3]

    @property
    def thickness(self) -> float:
        """Largest height of the outer surface over the base, m."""
        return float(self.vertices[self.surface, 2].max() - self.vertices[self.base, 2].min())

    @cached_property
    def digest(self) -> str:
        """SHA-256 of all that a solution depends on, which is the key of cached results."""
        digest = hashlib.sha256(self.kind.encode())
        parts: tuple[NDArray[Any], ...] = (self.vertices, self.cells, self.base, self.faces)
        for part in parts:
            digest.update(str(part.shape).encode())
            digest.update(np.ascontiguousarray(part).tobytes())
        return digest.hexdigest()
