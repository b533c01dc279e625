"""Mesh decimation by quadric error: edges collapse onto one of their ends, so that kept vertices are original ones."""

from __future__ import annotations

import heapq

import numpy as np

from tactiledata.arrays import Array, Indices

SPREAD = 0.01
"""Weight of the squared distance to a vertex, relative to the squared distances to the planes of its faces.

On flat parts all planes are at distance 0, and all collapses would start in one corner. This term spreads them evenly.
Probabilistic quadrics have the same term (Trettner and Kobbelt 2020)."""


def decimate(places: Array, faces: Indices, target: int) -> tuple[Indices, Indices]:
    """Indices of the vertices that a decimated mesh keeps, and its triangles between them.

    As in CoMA an edge collapses onto one of its ends, so that pooling is a choice of vertices. Faces may be those of a
    surface or, all together, those of the cells of a volume.

    Parameters
    ----------
    places : (v, 3) m
        Positions of the vertices.
    faces : (t, 3)
        Triangles as rows of ``places``.
    target : int
        Number of vertices to keep, at least 1. More stay where no edge is left to collapse.

    Returns
    -------
    kept : (target,)
        Rows of ``places``, ascending.
    faces : (u, 3)
        Triangles as rows of ``kept``.

    Source
    ------
    Garland and Heckbert 1997; the placement is that of Ranjan et al. 2018 (CoMA).
    """
    quadrics = vertex_quadrics(places, faces)
    points = np.concatenate([places, np.ones((len(places), 1))], axis=1)
    neighbours = _neighbours(faces, len(places))
    into = np.arange(len(places))
    alive = len(places)

    def price(first: int, second: int) -> tuple[float, int, int]:
        """Cost of the cheaper collapse of an edge, the vertex that stays and the vertex that is removed."""
        both = quadrics[first] + quadrics[second]
        stay_first = float(points[first] @ both @ points[first])
        stay_second = float(points[second] @ both @ points[second])
        return (stay_first, first, second) if stay_first <= stay_second else (stay_second, second, first)

    # queue all edges by cost; an entry is stale once the version of either vertex has changed
    version = np.zeros(len(places), np.int64)
    queue = [
        (*price(vertex, other), 0, 0) for vertex in range(len(places)) for other in neighbours[vertex] if vertex < other
    ]
    heapq.heapify(queue)
    while alive > target and queue:
        _, stays, goes, seen_stays, seen_goes = heapq.heappop(queue)
        if (version[stays], version[goes]) != (seen_stays, seen_goes):
            continue
        # collapse the cheapest edge: the vertex that stays takes over quadrics and neighbours
        quadrics[stays] += quadrics[goes]
        into[goes] = stays
        version[goes] = -1
        version[stays] += 1
        neighbours[stays] = (neighbours[stays] | neighbours[goes]) - {stays, goes}
        for other in neighbours[goes]:
            neighbours[other] = (neighbours[other] - {goes}) | ({stays} if other != stays else set())
        # queue the changed edges anew
        for other in neighbours[stays]:
            cost, keeps, drops = price(stays, other)
            heapq.heappush(queue, (cost, keeps, drops, int(version[keeps]), int(version[drops])))
        alive -= 1
    return _collapsed(faces, into)


def vertex_quadrics(places: Array, faces: Indices) -> Array:
    """Quadric of each vertex (v, 4, 4): a quadratic form of (x, y, z, 1) that gives a sum of squared distances.

    It sums the squared distances to the planes of the vertex's faces and, weighted by `SPREAD`, to the vertex itself.
    """
    corners = places[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    planes = np.concatenate([normals, -(normals * corners[:, 0]).sum(axis=1, keepdims=True)], axis=1)
    outer = planes[:, :, None] * planes[:, None, :]
    quadrics = np.zeros((len(places), 4, 4))
    for corner in range(3):
        np.add.at(quadrics, faces[:, corner], outer)
    quadrics[:, :3, :3] += SPREAD * np.eye(3)
    quadrics[:, :3, 3] -= SPREAD * places
    quadrics[:, 3, :3] -= SPREAD * places
    quadrics[:, 3, 3] += SPREAD * (places**2).sum(axis=1)
    return quadrics


def _neighbours(faces: Indices, count: int) -> list[set[int]]:
    """Set of vertices that share an edge with each of ``count`` vertices."""
    near: list[set[int]] = [set() for _ in range(count)]
    for a, b, c in faces.tolist():
        near[a] |= {b, c}
        near[b] |= {a, c}
        near[c] |= {a, b}
    return near


def _collapsed(faces: Indices, into: Indices) -> tuple[Indices, Indices]:
    """Kept vertices and the triangles that remain when each vertex is moved onto vertex ``into`` of it.

    Triangles that lose a corner are dropped, and of equal ones only the first is kept.
    """
    root = into
    while not np.array_equal(root[root], root):
        root = root[root]
    kept = np.unique(root)
    moved = np.searchsorted(kept, root[faces])
    is_whole = (moved[:, 0] != moved[:, 1]) & (moved[:, 1] != moved[:, 2]) & (moved[:, 0] != moved[:, 2])
    _, first = np.unique(np.sort(moved[is_whole], axis=1), axis=0, return_index=True)
    return kept, moved[is_whole][np.sort(first)]
