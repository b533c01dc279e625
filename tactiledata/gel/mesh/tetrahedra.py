"""Boundary of tetrahedra, and ten-node tetrahedra made of four-node ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.gel.mesh.pad import Indices

EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
"""Faces of a tetrahedron of positive volume, their corners counter-clockwise seen from outside."""


@dataclass(frozen=True)
class Boundary:
    """Boundary faces of tetrahedra, and counts of faults in how the cells join.

    Parameters
    ----------
    faces : (f, 3)
        Faces that only one cell has, outward.
    most_shared : int
        Largest number of cells that share a face; 2 in a sound mesh.
    folded : int
        Number of faces with both cells on the same side, where a cell is turned inside out.
    """

    faces: Indices
    most_shared: int
    folded: int


def boundary_of(cells: Indices) -> Boundary:
    """Return the boundary of cells (c, 4) of positive volume."""
    faces = cells[:, FACES].reshape(-1, 3)
    order = np.argsort(faces, axis=1)
    _, first, group, counts = np.unique(
        np.take_along_axis(faces, order, axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    # orientation of each face, +1 or -1, relative to its corners in ascending order
    turn = np.linalg.det(np.eye(3)[order])
    sides = np.abs(np.bincount(group.ravel(), weights=turn))
    return Boundary(faces[np.sort(first[counts == 1])], int(counts.max()), int(((counts == 2) & (sides > 1)).sum()))


def ten_node_cells(points: Array, cells: Indices, faces: Indices) -> tuple[Array, Indices, Indices]:
    """Return vertices (v, 3), cells (c, 10) and faces (f, 6) with a node in the middle of every edge.

    Four-node tetrahedra of a nearly incompressible body lock; ten-node ones do not.

    Parameters
    ----------
    points : (p, 3) m
        Corner nodes, which become the first vertices.
    cells : (c, 4)
        Four-node cells.
    faces : (f, 3)
        Faces of these cells.
    """
    ends = np.sort(cells[:, EDGES], axis=2).reshape(-1, 2)
    edges, edge_numbers = np.unique(ends, axis=0, return_inverse=True)
    middles = points[edges].mean(axis=1)
    ten_nodes = np.concatenate([cells, len(points) + edge_numbers.reshape(len(cells), 6)], axis=1)
    face_ends = np.sort(faces[:, EDGES[:3]], axis=2).reshape(-1, 2)
    keys = edges[:, 0] * len(points) + edges[:, 1]
    face_edges = np.searchsorted(keys, face_ends[:, 0] * len(points) + face_ends[:, 1])
    six_nodes = np.concatenate([faces, len(points) + face_edges.reshape(len(faces), 3)], axis=1)
    return np.concatenate([points, middles]), ten_nodes, six_nodes
