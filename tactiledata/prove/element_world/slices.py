"""Linear systems of a pad: elimination slice by slice across the grid, in single precision."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack
from scipy.sparse import csr_array

from tactiledata.prove.element_world.pad import Array, BrickPad


class Slices:
    """Numbers of the entries of a pad's stiffness in blocks of its slices.

    A brick joins neighbouring slices only, so that the matrix is block tridiagonal.

    Parameters
    ----------
    pad : BrickPad
        Its bonded nodes do not move.
    """

    def __init__(self, pad: BrickPad) -> None:
        free = np.flatnonzero(~pad.is_bonded)
        self.count = len(pad.lines[pad.axis])
        self.size = 3 * len(free) // self.count
        unknown = np.full((len(pad.places), 3), -1)
        unknown[free] = np.arange(3 * len(free)).reshape(-1, 3)
        self.unknown = unknown
        mine = unknown[pad.bricks].reshape(len(pad.bricks), 24)
        row, column = np.broadcast_arrays(mine[:, :, None], mine[:, None, :])
        row, column = row.ravel(), column.ravel()
        self._kept = (row >= 0) & (column >= 0)
        row, column = row[self._kept], column[self._kept]
        at, beside = row // self.size, column // self.size
        within = (row % self.size) * self.size + column % self.size
        key = (3 * at + beside - at + 1) * self.size**2 + within
        self._keys, self._entry = np.unique(key, return_inverse=True)
        self._edges = np.searchsorted(self._keys, np.arange(3 * self.count + 1) * self.size**2)

    def factor(self, stiffness: Array) -> Factor:
        """Return the factors of a matrix that is the sum of the bricks' (e, 8, 3, 8, 3)."""
        values = np.bincount(self._entry, stiffness.ravel()[self._kept], len(self._keys)).astype(np.float32)
        size = self.size
        pivots: list[Any] = []
        overs: list[Any] = []
        lowers: list[Any] = []
        for at in range(self.count):
            below, diagonal, above = (self._part(values, 3 * at + place) for place in range(3))
            block = _dense(*diagonal, size)
            lower = None
            if at:
                rows, columns = divmod(below[0], size)
                lower = csr_array((below[1], (rows, columns)), shape=(size, size))
                block -= lower @ overs[-1]
            lu, pivot, info = lapack.sgetrf(np.asfortranarray(block), overwrite_a=True)
            if info:
                raise ArithmeticError("the pad's stiffness is singular")
            over = None
            if at + 1 < self.count:
                over, _ = lapack.sgetrs(lu, pivot, np.asfortranarray(_dense(*above, size)), overwrite_b=True)
            pivots.append((lu, pivot))
            overs.append(over)
            lowers.append(lower)
        return Factor(pivots, overs, lowers)

    def _part(self, values: NDArray[np.float32], block: int) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        rows = slice(self._edges[block], self._edges[block + 1])
        return self._keys[rows] - block * self.size**2, values[rows]

    def gathered(self, forces: Array, pad: BrickPad) -> Array:
        """Return the sums (unknowns,) of the bricks' forces (e, 8, 3) at the nodes that can move."""
        index = self.unknown[pad.bricks].ravel()
        kept = index >= 0
        return np.bincount(index[kept], forces.ravel()[kept], self.count * self.size)


def _dense(places: NDArray[np.int64], values: NDArray[np.float32], size: int) -> NDArray[np.float32]:
    block = np.zeros((size, size), dtype=np.float32)
    block.ravel()[places] = values
    return block


class Factor:
    """The factors of a block tridiagonal matrix.

    Parameters
    ----------
    pivots : list of (factors, pivots)
        Of what is left of each diagonal block.
    overs : list of arrays
        Solutions for the blocks above the diagonal.
    lowers : list of sparse arrays
        The blocks below the diagonal.
    """

    def __init__(self, pivots: list[Any], overs: list[Any], lowers: list[Any]) -> None:
        self._pivots, self._overs, self._lowers = pivots, overs, lowers

    def solve(self, right: Array) -> Array:
        """Return the solution (n,) for a right side (n,), to single precision."""
        scale = float(np.abs(right).max(initial=0.0)) or 1.0
        parts = (right / scale).astype(np.float32).reshape(len(self._pivots), -1)
        done: list[NDArray[np.float32]] = []
        for part, (lu, pivot), lower in zip(parts, self._pivots, self._lowers, strict=True):
            known = part if lower is None else part - lower @ done[-1]
            done.append(lapack.sgetrs(lu, pivot, known)[0])
        for at in range(len(done) - 2, -1, -1):
            done[at] = done[at] - self._overs[at] @ done[at + 1]
        return scale * np.concatenate(done).astype(float)
