"""A sparse symmetric factor in single precision, its columns gathered into dense blocks."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse.linalg import SuperLU

from tactiledata.arrays import Array, Indices, SingleArray

LANES = 8
"""Right-hand sides solved together on a thread; always so many, with zeros among them, so that none depends on how many
others there are."""


@dataclass(frozen=True)
class BlockFactor:
    """``P A P' = L D L'`` with L's columns of like pattern stored as dense blocks ("supernodes").

    A solution is good to about 1e-6: for iterations that measure their residual in double precision. With b right-hand
    sides at once, dense products of blocks do what a column at a time does in several times as long.

    Parameters
    ----------
    order : (n,)
        Place of each unknown in the elimination.
    starts : (s + 1,)
        First column of each block.
    rows, row_starts : (r,), (s + 1,)
        Rows below the diagonal of each block.
    below, below_starts : flat (rows of a block, columns of a block) values
    corners, corner_starts : flat inverses of the blocks' unit triangles
    inverse_diagonal : (n,)
    """

    order: Indices
    starts: Indices
    rows: Indices
    row_starts: Indices
    below: SingleArray
    below_starts: Indices
    corners: SingleArray
    corner_starts: Indices
    inverse_diagonal: SingleArray

    @staticmethod
    def of(factor: SuperLU) -> BlockFactor:
        """From a factor of a symmetric matrix without row exchanges."""
        lower = factor.L.tocsc()
        lower.sort_indices()
        starts = _block_starts(lower.indptr, lower.indices)
        rows, below, corners = [], [], []
        for first, end in itertools.pairwise(starts):
            width = end - first
            beneath = lower.indices[lower.indptr[end - 1] + 1 : lower.indptr[end]]
            triangle, rectangle = np.eye(width), np.empty((len(beneath), width))
            for place in range(width):
                column = lower.data[lower.indptr[first + place] : lower.indptr[first + place + 1]]
                triangle[place:, place] = column[: width - place]
                rectangle[:, place] = column[width - place :]
            rows.append(beneath.astype(np.int64))
            below.append(rectangle.ravel())
            corners.append(np.linalg.inv(triangle).ravel())
        return BlockFactor(
            factor.perm_c.astype(np.int64),
            starts,
            np.concatenate(rows),
            _ends(rows),
            np.concatenate(below).astype(np.float32),
            _ends(below),
            np.concatenate(corners).astype(np.float32),
            _ends(corners),
            (1.0 / factor.U.diagonal()).astype(np.float32),
        )

    def solve(self, right: Array, threads: Executor | None = None) -> Array:
        """Solutions (b, n) of right-hand sides (b, n)."""
        solution = np.empty(right.shape)
        shares = [slice(first, first + LANES) for first in range(0, len(right), LANES)]
        deque((map if threads is None else threads.map)(partial(self._solve_some, right, solution), shares), maxlen=0)
        return solution

    def _solve_some(self, right: Array, solution: Array, share: slice) -> None:
        some = right[share]
        work = np.zeros((right.shape[1], LANES), dtype=np.float32)
        work[self.order, : len(some)] = some.T
        _solve(
            self.starts,
            self.rows,
            self.row_starts,
            self.below,
            self.below_starts,
            self.corners,
            self.corner_starts,
            self.inverse_diagonal,
            work,
        )
        solution[share] = work[self.order, : len(some)].T


def _block_starts(starts: NDArray[np.int32], rows: NDArray[np.int32]) -> Indices:
    """First columns of runs of columns that have the same rows below the run."""
    firsts = [0]
    for column in range(1, len(starts) - 1):
        before = rows[starts[column - 1] + 1 : starts[column]]
        if not np.array_equal(before, rows[starts[column] : starts[column + 1]]):
            firsts.append(column)
    return np.array([*firsts, len(starts) - 1], dtype=np.int64)


def _ends(parts: Sequence[NDArray[Any]]) -> Indices:
    return np.concatenate([[0], np.cumsum([len(part) for part in parts])]).astype(np.int64)


@njit(nogil=True, cache=True)
def _solve(
    starts: Indices,
    rows: Indices,
    row_starts: Indices,
    below: SingleArray,
    below_starts: Indices,
    corners: SingleArray,
    corner_starts: Indices,
    inverse_diagonal: SingleArray,
    values: SingleArray,
) -> None:
    """Replace right-hand sides (n, lanes) by solutions."""
    blocks = len(starts) - 1
    lanes = values.shape[1]
    tallest = (row_starts[1:] - row_starts[:-1]).max()
    widest = (starts[1:] - starts[:-1]).max()
    gathered = np.empty((tallest, lanes), np.float32)
    own_space = np.empty((widest, lanes), np.float32)
    for block in range(blocks):
        first, end = starts[block], starts[block + 1]
        width, height = end - first, row_starts[block + 1] - row_starts[block]
        own = own_space[:width]
        np.dot(corners[corner_starts[block] : corner_starts[block + 1]].reshape(width, width), values[first:end], own)
        values[first:end] = own
        if height == 0:
            continue
        added = gathered[:height]
        np.dot(below[below_starts[block] : below_starts[block + 1]].reshape(height, width), own, added)
        for row in range(height):
            target = values[rows[row_starts[block] + row]]
            for lane in range(lanes):
                target[lane] -= added[row, lane]
    for block in range(blocks - 1, -1, -1):
        first, end = starts[block], starts[block + 1]
        width, height = end - first, row_starts[block + 1] - row_starts[block]
        own = own_space[:width]
        if height > 0:
            known = gathered[:height]
            for row in range(height):
                known[row] = values[rows[row_starts[block] + row]]
            rectangle = below[below_starts[block] : below_starts[block + 1]].reshape(height, width)
            np.dot(rectangle.T, known, own)
        else:
            own[:] = 0.0
        for row in range(width):
            for lane in range(lanes):
                own[row, lane] = values[first + row, lane] * inverse_diagonal[first + row] - own[row, lane]
        triangle = corners[corner_starts[block] : corner_starts[block + 1]].reshape(width, width)
        np.dot(triangle.T, own, values[first:end])
