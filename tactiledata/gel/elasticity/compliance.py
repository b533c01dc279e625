"""Factorised stiffness of a pad, and the displacement of its surface under unit loads (kept in a cache on disk)."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array
from scipy.sparse.linalg import SuperLU, splu
from threadpoolctl import ThreadpoolController

from tactiledata.arrays import Array
from tactiledata.contract.atomic import write_atomic
from tactiledata.gel.elasticity.stiffness import linear_stiffness
from tactiledata.gel.elasticity.triangular import BlockFactor
from tactiledata.gel.mesh.cells import CellQuadrature
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.surface import ContactSurface

BATCH = 96
"""Right-hand sides solved at once: the factor is read from memory once for all of them."""
WIDE = 24
"""Unit loads that are solved together; more are hardly faster, and would leave threads without any."""
LAYOUT = 4
"""Version of the layout and the rounding of cached files; raising it makes new files."""


@dataclass(frozen=True)
class FactorisedPad:
    """Linear stiffness of a pad with Young's modulus 1, factorised for its free degrees of freedom.

    It is assembled and factorised when it is first asked for: what is read from the cache needs neither.

    Parameters
    ----------
    mesh : PadMesh
        Mesh of v nodes.
    quadrature : CellQuadrature
        Its weights carry factors on the cells' modulus.
    poisson_ratio : float
        Below 0.5.
    """

    mesh: PadMesh
    quadrature: CellQuadrature
    poisson_ratio: float

    @cached_property
    def stiffness(self) -> csr_array:
        """Stiffness (3 v, 3 v), m, of all degrees of freedom."""
        return linear_stiffness(self.mesh, self.quadrature, self.poisson_ratio)

    @cached_property
    def factor(self) -> SuperLU:
        """Factor of the part that is not held, in the ordering for symmetric matrices."""
        free = self.mesh.free
        reduced = csc_array(self.stiffness[free][:, free])
        return splu(reduced, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    @cached_property
    def digest(self) -> str:
        """Hash of the mesh and of the cells' relative stiffness."""
        weights = np.ascontiguousarray(self.quadrature.weights).tobytes()
        return hashlib.sha256(self.mesh.digest.encode() + weights).hexdigest()

    def solve(self, forces: Array) -> Array:
        """Displacements (b, v, 3), m, under nodal forces (b, v, 3), m^2 (N over Young's modulus)."""
        count = len(forces)
        free = self.mesh.free
        right = np.asfortranarray(forces.reshape(count, -1)[:, free].T)
        displacement = np.zeros((count, 3 * len(self.mesh.vertices)))
        displacement[:, free] = self.factor.solve(right).T
        return displacement.reshape(count, -1, 3)

    def solve_roughly(self, forces: Array, threads: Executor | None = None) -> Array:
        """Displacements as by ``solve``, with a relative error of about 1e-6, in a fraction of the time."""
        count = len(forces)
        free = self.mesh.free
        displacement = np.zeros((count, 3 * len(self.mesh.vertices)))
        displacement[:, free] = self.blocks.solve(forces.reshape(count, -1)[:, free], threads)
        return displacement.reshape(count, -1, 3)

    def solve_refined(self, forces: Array) -> Array:
        """Displacements (b, v, 3), m, of forces (b, v, 3), N, as by ``solve`` but faster; relative error 1e-11."""
        displacement = self.solve_roughly(forces)
        count = len(forces)
        residual = forces.reshape(count, -1) - (self.stiffness @ displacement.reshape(count, -1).T).T
        return displacement + self.solve_roughly(residual.reshape(forces.shape))

    @cached_property
    def blocks(self) -> BlockFactor:
        """Factor in single precision, for fast approximate solutions."""
        return BlockFactor.of(self.factor)


def surface_response(pad: FactorisedPad, surface: ContactSurface) -> NDArray[np.float32]:
    """Displacements of surface nodes under unit patch forces: (s, 3, m, 3), 1/m, for a Young's modulus of 1.

    The result is cached on disk in ``cache_folder``, by mesh and Poisson's ratio; an unreadable file is made again.
    """
    key = f"{pad.digest[:24]}-{float(pad.poisson_ratio)!r}-{LAYOUT}"
    path = cache_folder() / "gel" / f"{key}.npy"
    shape = (len(surface.nodes), 3, len(surface.corners), 3)
    cached = _load(path, shape)
    if cached is not None:
        return cached
    response = _solve_response(pad, surface).reshape(shape)
    content = io.BytesIO()
    np.save(content, response, allow_pickle=False)
    # a folder that cannot be written costs time at the next start, nothing else
    with contextlib.suppress(OSError):
        write_atomic(path, content.getvalue())
    return response


def cache_folder() -> Path:
    """Folder of results that can be computed again: ``TACTILEDATA_CACHE``, or the user's cache folder."""
    override = os.environ.get("TACTILEDATA_CACHE")
    if override:
        return Path(override)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "tactiledata"


def _load(path: Path, shape: tuple[int, ...]) -> NDArray[np.float32] | None:
    """Read a cached array, or return ``None`` where it is missing, damaged or of another shape."""
    try:
        cached = np.load(path, allow_pickle=False)
    except (OSError, ValueError):
        return None
    return cached if cached.shape == shape and cached.dtype == np.float32 else None


def _solve_response(pad: FactorisedPad, surface: ContactSurface) -> NDArray[np.float32]:
    """Displacements (3 s, 3 m), 1/m, of surface nodes under a unit force on each patch and axis."""
    free = pad.mesh.free
    rows = np.full(3 * len(pad.mesh.vertices), -1)
    rows[free] = np.arange(len(free))
    surface_rows = rows[(3 * surface.nodes[:, None] + np.arange(3)).ravel()]
    spread = surface.averaging.T.tocsc()
    count = len(surface.corners)
    response = np.zeros((len(surface_rows), 3 * count), dtype=np.float32)
    per_batch = BATCH // 3
    # loads are divided among threads; BLAS products must not start threads of their own beside them
    with (
        ThreadpoolController().limit(limits=1, user_api="blas"),
        ThreadPoolExecutor(len(os.sched_getaffinity(0))) as threads,
    ):
        for start in range(0, count, per_batch):
            columns = range(start, min(start + per_batch, count))
            # nodal forces of a unit force on each patch of the batch, along each axis
            loads = np.zeros((3 * len(columns), len(free)))
            for place, column in enumerate(columns):
                entries = slice(spread.indptr[column], spread.indptr[column + 1])
                for axis in range(3):
                    load_rows = rows[3 * surface.nodes[spread.indices[entries]] + axis]
                    is_free = load_rows >= 0
                    loads[3 * place + axis, load_rows[is_free]] = spread.data[entries][is_free]
            # single precision is enough: the response is stored so, and the compliance is made symmetric from it
            displacement = pad.blocks.solve(loads, threads, WIDE)
            response[:, 3 * start : 3 * start + len(loads)] = np.where(
                surface_rows[:, None] >= 0, displacement.T[surface_rows], 0.0
            )
    return response


def patch_compliance(response: NDArray[np.float32], surface: ContactSurface) -> NDArray[np.float32]:
    """Return the mean displacement of each patch by a unit force on each patch (m, m, 3, 3), 1/m.

    Block (i, j) maps a force on patch j to the displacement of patch i, for a Young's modulus of 1. The result is made
    symmetric.

    Parameters
    ----------
    response : (s, 3, m, 3) 1/m
        Displacements of the s surface nodes by unit forces on the m patches, as `surface_response` returns them.
    surface : ContactSurface
        Nodes and patches of the same pad.
    """
    count = len(surface.corners)
    flat = surface.averaging.astype(np.float32) @ response.reshape(len(surface.nodes), -1)
    blocks = flat.reshape(count, 3, count, 3).transpose(0, 2, 1, 3)
    symmetric = (blocks + blocks.transpose(1, 0, 3, 2)) / 2
    return np.ascontiguousarray(symmetric, dtype=np.float32)
