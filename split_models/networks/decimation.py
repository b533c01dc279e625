"""A mesh with fewer vertices, all of them vertices of the mesh it came from: edges collapsed by quadric error."""

from __future__ import annotations

import heapq

import numpy as np

from tactiledata.arrays import Array, Indices

SPREAD = 0.01
"""Weight of the squared distance to a vertex beside those to the planes of its faces.

On flat parts all planes are at distance 0, and collapses would start in one corner and eat their way through; with it
they spread evenly. Probabilistic quadrics have the same term (Trettner and Kobbelt 2020)."""


def decimate(places: Array, faces: Indices, target: int) -> tuple[Indices, Indices]:
    """Which vertices stay, and the faces between them.

    As in CoMA an edge collapses onto one of its ends, so that pooling is a choice of vertices. Faces may be those of a
    surface or, all together, those of the cells of a volume.

    Parameters
    ----------
    places : (v, 3) m
    faces : (t, 3)
    target : int
        How many vertices stay, at least 1.

    Returns
    -------
    kept : (target,)
        Rows of ``places``, ascending.
    faces : (u, 3)
        Rows of ``kept``.

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
        """Cost of the cheaper collapse, the vertex that stays and the one that goes."""
        both = quadrics[first] + quadrics[second]
        stay_first = float(points[first] @ both @ points[first])
        stay_second = float(points[second] @ both @ points[second])
        return (stay_first, first, second) if stay_first <= stay_second else (stay_second, second, first)

    version = np.zeros(len(places), np.int64)
    queue = [
        (*price(vertex, other), 0, 0) for vertex in range(len(places)) for other in neighbours[vertex] if vertex < other
    ]
    heapq.heapify(queue)
    while alive > target and queue:
        _, stays, goes, seen_stays, seen_goes = heapq.heappop(queue)
        if (version[stays], version[goes]) != (seen_stays, seen_goes):
            continue
        quadrics[stays] += quadrics[goes]
        into[goes] = stays
        version[goes] = -1
        version[stays] += 1
        neighbours[stays] = (neighbours[stays] | neighbours[goes]) - {stays, goes}
        for other in neighbours[goes]:
            neighbours[other] = (neighbours[other] - {goes}) | ({stays} if other != stays else set())
        for other in neighbours[stays]:
            cost, keeps, drops = price(stays, other)
            heapq.heappush(queue, (cost, keeps, drops, int(version[keeps]), int(version[drops])))
        alive -= 1
    return _collapsed(faces, into)


def vertex_quadrics(places: Array, faces: Indices) -> Array:
    """Sum (v, 4, 4) of squared distances, as quadratic forms of (x, y, z, 1), to the planes of a vertex's faces and,
    weighted by `SPREAD`, to the vertex itself.
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
    near: list[set[int]] = [set() for _ in range(count)]
    for a, b, c in faces.tolist():
        near[a] |= {b, c}
        near[b] |= {a, c}
        near[c] |= {a, b}
    return near


def _collapsed(faces: Indices, into: Indices) -> tuple[Indices, Indices]:
    root = into
    while not np.array_equal(root[root], root):
        root = root[root]
    kept = np.unique(root)
    moved = np.searchsorted(kept, root[faces])
    is_whole = (moved[:, 0] != moved[:, 1]) & (moved[:, 1] != moved[:, 2]) & (moved[:, 0] != moved[:, 2])
    _, first = np.unique(np.sort(moved[is_whole], axis=1), axis=0, return_index=True)
    return kept, moved[is_whole][np.sort(first)]
