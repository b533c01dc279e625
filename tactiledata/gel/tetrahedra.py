"""Tetrahedra: the faces of their boundary, and ten nodes out of four."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactiledata.gel.pad import Indices

Array = NDArray[np.float64]

EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
"""Of a tetrahedron of positive volume, seen from outside against the clock."""


def boundary_faces(cells: Indices) -> tuple[Indices, int]:
    """Faces (f, 3) that only one of the cells (c, 4) has, outward, and how many cells share the most shared face."""
    faces = cells[:, FACES].reshape(-1, 3)
    _, first, counts = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return faces[np.sort(first[counts == 1])], int(counts.max())


def ten_node_cells(points: Array, cells: Indices, faces: Indices) -> tuple[Array, Indices, Indices]:
    """Vertices (v, 3), cells (c, 10) and six-node faces (f, 6): a node in the middle of every edge.

    Four-node tetrahedra of a nearly incompressible body lock; ten-node ones do not.
    """
    ends = np.sort(cells[:, EDGES], axis=2).reshape(-1, 2)
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    middles = points[edges].mean(axis=1)
    ten = np.concatenate([cells, len(points) + number.reshape(len(cells), 6)], axis=1)
    of_faces = np.sort(faces[:, EDGES[:3]], axis=2).reshape(-1, 2)
    keys = edges[:, 0] * len(points) + edges[:, 1]
    found = np.searchsorted(keys, of_faces[:, 0] * len(points) + of_faces[:, 1])
    six = np.concatenate([faces, len(points) + found.reshape(len(faces), 3)], axis=1)
    return np.concatenate([points, middles]), ten, six
