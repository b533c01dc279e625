"""Tetrahedra: the faces of their boundary, and ten nodes out of four."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.gel.mesh.pad import Indices

EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
"""Of a tetrahedron of positive volume, seen from outside against the clock."""


@dataclass(frozen=True)
class Boundary:
    """How tetrahedra join.

    Parameters
    ----------
    faces : (f, 3)
        Faces that only one cell has, outward.
    most_shared : int
        How many cells share the most shared face; 2 in a sound mesh.
    folded : int
        Faces with both of their cells on one side: a cell is turned inside out there.
    """

    faces: Indices
    most_shared: int
    folded: int


def boundary_of(cells: Indices) -> Boundary:
    """The boundary of cells (c, 4) of positive volume."""
    faces = cells[:, FACES].reshape(-1, 3)
    order = np.argsort(faces, axis=1)
    _, first, group, counts = np.unique(
        np.take_along_axis(faces, order, axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    # +1 or -1: whether the corners run upwards one way round or the other
    turn = np.linalg.det(np.eye(3)[order])
    sides = np.abs(np.bincount(group.ravel(), weights=turn))
    return Boundary(faces[np.sort(first[counts == 1])], int(counts.max()), int(((counts == 2) & (sides > 1)).sum()))


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
