"""The graph of a mesh for graph convolutions: neighbours, scaled Laplacians, and maps to coarser levels and back."""

from __future__ import annotations

import contextlib
import hashlib
import io
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from split_models.networks.decimation import decimate
from tactiledata.arrays import Array, Indices
from tactiledata.contract.atomic import write_atomic
from tactiledata.errors import StoreError
from tactiledata.gel.elasticity.compliance import cache_folder
from tactiledata.store.read.meshes import StoredMesh

LAYOUT = 1
"""Version of the cached files' layout; raising it makes new files."""
POOLINGS = 4
"""Coarser levels of a mesh unless stated, as in CoMA."""

_HEXAHEDRON = np.array([[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
# corners 0 1 2 and the edge nodes 01, 12, 20, as gel/pad.py numbers ten-node tetrahedra
_TETRAHEDRON = np.array([[0, 1, 2, 4, 5, 6], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 2, 3, 6, 9, 7]])


@dataclass(frozen=True)
class Topology:
    """The vertices whose displacements a store keeps, and the triangles between them.

    Parameters
    ----------
    places : (v, 3) m
        Undeformed positions, gel frame, of the first pad.
    faces : (t, 3)
        Triangles as rows of ``places``: those of a surface, or all faces of all cells of a volume.
    """

    places: Array
    faces: Indices

    @property
    def n_vertices(self) -> int:
        """Number of vertices, v."""
        return len(self.places)

    @property
    def digest(self) -> str:
        """SHA-256 of the number of vertices and of the triangles; positions do not enter."""
        return hashlib.sha256(f"{self.n_vertices};".encode() + np.sort(self.faces, axis=1).tobytes()).hexdigest()


def topology_of(mesh: StoredMesh) -> Topology:
    """The topology of a mesh of a store, for any choice of kept nodes.

    Raises
    ------
    StoreError
        The kept nodes share no face.
    """
    pad = mesh.pad()
    place = np.full(pad.vertices.shape[1], -1)
    place[pad.kept] = np.arange(len(pad.kept))
    faces = place[cell_faces(pad.cells)]
    faces = faces[(faces >= 0).all(axis=1)]
    if not len(faces):
        raise StoreError(
            f"the {len(pad.kept)} nodes that the mesh {mesh.name!r} keeps share no face",
            "nodes of a surface or of a volume",
            "Replay again with --keep all or --keep surface.",
        )
    return Topology(pad.vertices[0][pad.kept], faces)


def cell_faces(cells: Indices) -> Indices:
    """Triangles (t, 3) of all faces of cells (c, 8) or (c, 10); a face that two cells share is listed once."""
    if cells.shape[1] == 8:
        quads = cells[:, _HEXAHEDRON].reshape(-1, 4)
        quads = quads[_first_of_equal(quads)]
        triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    else:
        six = cells[:, _TETRAHEDRON].reshape(-1, 6)
        parts = six[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]]
        triangles = parts.reshape(-1, 3)
    return triangles[_first_of_equal(triangles)]


def _first_of_equal(faces: Indices) -> Indices:
    """Rows of the first of each set of faces with the same corners, in their order."""
    return np.sort(np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1])


@dataclass(frozen=True)
class Hierarchy:
    """A mesh at several levels of detail, the finest first.

    Parameters
    ----------
    digest : str
        Digest of the finest level's topology.
    sizes : (levels,) int
        Number of vertices of each level.
    laplacians : (levels,) sparse (v, v)
        Graph Laplacians, scaled to eigenvalues in [-1, 1].
    down : (levels - 1,) sparse (v_next, v)
        Choices of the vertices that the next level keeps.
    up : (levels - 1,) sparse (v, v_next)
        Barycentric weights of each vertex in the nearest triangle of the coarser level.
    """

    digest: str
    sizes: tuple[int, ...]
    laplacians: tuple[csr_array, ...]
    down: tuple[csr_array, ...]
    up: tuple[csr_array, ...]

    def arrays(self) -> dict[str, NDArray[np.generic]]:
        """All arrays by name, for a file; `from_arrays` is the inverse."""
        arrays: dict[str, NDArray[np.generic]] = {"sizes": np.asarray(self.sizes)}
        for kind in ("laplacians", "down", "up"):
            for level, matrix in enumerate(getattr(self, kind)):
                for part in ("data", "indices", "indptr"):
                    arrays[f"{kind}.{level}.{part}"] = getattr(matrix, part)
        return arrays

    @classmethod
    def from_arrays(cls, digest: str, arrays: Mapping[str, NDArray[np.generic]]) -> Hierarchy:
        """The hierarchy of a topology's digest and of the arrays that `arrays` gave."""
        sizes = tuple(int(size) for size in arrays["sizes"])

        def matrix(kind: str, level: int, shape: tuple[int, int]) -> csr_array:
            parts = tuple(arrays[f"{kind}.{level}.{part}"] for part in ("data", "indices", "indptr"))
            return csr_array(parts, shape=shape)

        steps = list(enumerate(pairwise(sizes)))
        return cls(
            digest,
            sizes,
            tuple(matrix("laplacians", level, (size, size)) for level, size in enumerate(sizes)),
            tuple(matrix("down", level, (coarse, fine)) for level, (fine, coarse) in steps),
            tuple(matrix("up", level, (fine, coarse)) for level, (fine, coarse) in steps),
        )


def build_hierarchy(topology: Topology, poolings: int = POOLINGS) -> Hierarchy:
    """A mesh and ``poolings`` coarser levels, each with half as many vertices; cached on disk by the mesh's digest."""
    key = hashlib.sha256(topology.digest.encode() + topology.places.tobytes()).hexdigest()
    path = cache_folder() / "mesh_graph" / f"{key[:32]}-{poolings}-{LAYOUT}.npz"
    kept = _load(path)
    if kept is not None:
        return Hierarchy.from_arrays(topology.digest, kept)
    built = _build(topology, poolings)
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, **built.arrays())
    # a folder that cannot be written costs time at the next start, nothing else
    with contextlib.suppress(OSError):
        write_atomic(path, content.getvalue())
    return built


def _load(path: Path) -> dict[str, NDArray[np.generic]] | None:
    """Arrays of a cached file; None where it does not exist or cannot be read."""
    try:
        with np.load(path, allow_pickle=False) as kept:
            return dict(kept)
    except (OSError, ValueError):
        return None


def _build(topology: Topology, poolings: int) -> Hierarchy:
    """The hierarchy of a topology, computed anew."""
    places, faces = topology.places, topology.faces
    sizes, laplacians = [len(places)], [scaled_laplacian(faces, len(places))]
    down, up = [], []
    for _ in range(poolings):
        kept, coarse = decimate(places, faces, max(1, (len(places) + 1) // 2))
        down.append(_selection(kept, len(places)))
        up.append(_barycentric(places, kept, coarse))
        places, faces = places[kept], coarse
        sizes.append(len(places))
        laplacians.append(scaled_laplacian(faces, len(places)))
    return Hierarchy(topology.digest, tuple(sizes), tuple(laplacians), tuple(down), tuple(up))


def scaled_laplacian(faces: Indices, count: int) -> csr_array:
    """Normalised graph Laplacian (count, count) of triangles, scaled to eigenvalues in [-1, 1]: -D^-1/2 A D^-1/2.

    It is 2 L / 2 - 1, with the bound 2 on the eigenvalues of L. A vertex without neighbours has a row of zeros.

    Source: Defferrard et al. 2016, section 2.1.
    """
    pairs = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    pairs = np.unique(np.sort(pairs, axis=1), axis=0)
    both = np.concatenate([pairs, pairs[:, ::-1]])
    degree = np.bincount(both[:, 0], minlength=count)
    weight = -1.0 / np.sqrt(degree[both[:, 0]] * degree[both[:, 1]])
    return _as_float32(coo_array((weight, (both[:, 0], both[:, 1])), shape=(count, count)).tocsr())


def _selection(kept: Indices, count: int) -> csr_array:
    """Sparse matrix (k, count) that picks the kept vertices."""
    ones = np.ones(len(kept))
    return _as_float32(coo_array((ones, (np.arange(len(kept)), kept)), shape=(len(kept), count)).tocsr())


def _barycentric(places: Array, kept: Indices, coarse: Indices) -> csr_array:
    """Sparse weights (v, v_next) that interpolate values of the coarser level at the vertices of the finer one.

    A fine vertex takes barycentric weights in the nearest coarse triangle, or the nearest vertex where no triangle is
    left. A vertex that was kept takes its own value.
    """
    corners, weights = _nearest_weights(places, places[kept], coarse)
    corners[kept] = np.arange(len(kept))[:, None]
    weights[kept] = (1.0, 0.0, 0.0)
    rows = np.repeat(np.arange(len(places)), 3)
    matrix = coo_array((weights.ravel(), (rows, corners.ravel())), shape=(len(places), len(kept))).tocsr()
    matrix.eliminate_zeros()
    return _as_float32(matrix)


def _nearest_weights(places: Array, coarse_places: Array, coarse: Indices) -> tuple[Indices, Array]:
    """Corners (v, 3) of the nearest coarse triangle of each place, as rows of ``coarse_places``, and their weights."""
    if not len(coarse):
        squares = ((places[:, None] - coarse_places[None]) ** 2).sum(axis=-1)
        return np.repeat(squares.argmin(axis=1)[:, None], 3, axis=1), np.tile((1.0, 0.0, 0.0), (len(places), 1))
    _, triangle, nearest = igl.point_mesh_squared_distance(places, coarse_places, coarse)
    corners = coarse[np.ravel(triangle)]
    a, b, c = (coarse_places[corners[:, corner]] for corner in range(3))
    weights = np.asarray(igl.barycentric_coordinates(nearest, a, b, c))
    # barycentric coordinates in a sliver triangle are ill conditioned: take its nearest corner instead
    distance = np.stack([((nearest - corner) ** 2).sum(axis=1) for corner in (a, b, c)], axis=1)
    bad = ~np.isfinite(weights).all(axis=1) | (weights < -1e-6).any(axis=1)
    weights[bad] = np.eye(3)[distance[bad].argmin(axis=1)]
    weights = np.clip(weights, 0.0, None)
    return corners.copy(), weights / weights.sum(axis=1, keepdims=True)


def _as_float32(matrix: csr_array) -> csr_array:
    """The matrix with float32 values and sorted int64 indices, as `SparseMap` stores it."""
    matrix.sort_indices()
    return csr_array(
        (matrix.data.astype(np.float32), matrix.indices.astype(np.int64), matrix.indptr.astype(np.int64)),
        shape=matrix.shape,
    )
