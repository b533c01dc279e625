"""Factor of a sparse symmetric matrix in single precision, with columns gathered into dense blocks."""

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
"""Right-hand sides solved together on a thread.

A smaller number is filled up with zeros, so that no solution depends on how many others are solved with it."""


@dataclass(frozen=True)
class BlockFactor:
    """``P A P' = L D L'`` with L's columns of like pattern stored as dense blocks ("supernodes").

    A solution has a relative error of about 1e-6, which serves iterations that compute their residual in double
    precision. For many right-hand sides, dense products of blocks are several times faster than column by column.

    Parameters
    ----------
    order : (n,)
        Place of each unknown in the elimination.
    starts : (s + 1,)
        First column of each block.
    rows, row_starts : (r,), (s + 1,)
        Rows below the diagonal block of each block, and where each block's rows start.
    below, below_starts : (k,), (s + 1,)
        Values of L below each diagonal block, flat in (rows, columns), and where each block's values start.
    corners, corner_starts : (c,), (s + 1,)
        Inverse of each block's unit triangle, flat, and where each block's values start.
    inverse_diagonal : (n,)
        1 / D.
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
        """Convert SciPy's factor of a symmetric matrix, which must have been computed without row exchanges."""
        lower = factor.L.tocsc()
        lower.sort_indices()
        starts = _block_starts(lower.indptr, lower.indices)
        rows, below, corners = [], [], []
        for first, end in itertools.pairwise(starts):
            width = end - first
            rows_below = lower.indices[lower.indptr[end - 1] + 1 : lower.indptr[end]]
            triangle, rectangle = np.eye(width), np.empty((len(rows_below), width))
            for place in range(width):
                column = lower.data[lower.indptr[first + place] : lower.indptr[first + place + 1]]
                triangle[place:, place] = column[: width - place]
                rectangle[:, place] = column[width - place :]
            rows.append(rows_below.astype(np.int64))
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
        """Return solutions (b, n) of right-hand sides (b, n); groups of ``LANES`` run on the given threads."""
        solution = np.empty(right.shape)
        shares = [slice(first, first + LANES) for first in range(0, len(right), LANES)]
        deque((map if threads is None else threads.map)(partial(self._solve_some, right, solution), shares), maxlen=0)
        return solution

    def _solve_some(self, right: Array, solution: Array, share: slice) -> None:
        """Write the solutions of one group of right-hand sides (b, n) to the same rows of ``solution``."""
        part = right[share]
        work = np.zeros((right.shape[1], LANES), dtype=np.float32)
        work[self.order, : len(part)] = part.T
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
        solution[share] = work[self.order, : len(part)].T


def _block_starts(starts: NDArray[np.int32], rows: NDArray[np.int32]) -> Indices:
    """First columns of runs of columns with the same pattern, and the number of columns at the end.

    ``starts`` and ``rows`` are the column pointers and row numbers of L.
    """
    firsts = [0]
    for column in range(1, len(starts) - 1):
        before = rows[starts[column - 1] + 1 : starts[column]]
        if not np.array_equal(before, rows[starts[column] : starts[column + 1]]):
            firsts.append(column)
    return np.array([*firsts, len(starts) - 1], dtype=np.int64)


def _ends(parts: Sequence[NDArray[Any]]) -> Indices:
    """Places (s + 1,) at which each part starts, and the last ends, when parts are concatenated."""
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
    """Replace right-hand sides ``values`` (n, lanes), in elimination order, by their solutions."""
    blocks = len(starts) - 1
    lanes = values.shape[1]
    tallest = (row_starts[1:] - row_starts[:-1]).max()
    widest = (starts[1:] - starts[:-1]).max()
    space = np.empty((tallest, lanes), np.float32)
    block_space = np.empty((widest, lanes), np.float32)
    # forward substitution with L
    for block in range(blocks):
        first, end = starts[block], starts[block + 1]
        width, height = end - first, row_starts[block + 1] - row_starts[block]
        block_values = block_space[:width]
        np.dot(
            corners[corner_starts[block] : corner_starts[block + 1]].reshape(width, width),
            values[first:end],
            block_values,
        )
        values[first:end] = block_values
        if height == 0:
            continue
        products = space[:height]
        np.dot(below[below_starts[block] : below_starts[block + 1]].reshape(height, width), block_values, products)
        for row in range(height):
            target = values[rows[row_starts[block] + row]]
            for lane in range(lanes):
                target[lane] -= products[row, lane]
    # backward substitution with D and the transpose of L
    for block in range(blocks - 1, -1, -1):
        first, end = starts[block], starts[block + 1]
        width, height = end - first, row_starts[block + 1] - row_starts[block]
        block_values = block_space[:width]
        if height > 0:
            below_values = space[:height]
            for row in range(height):
                below_values[row] = values[rows[row_starts[block] + row]]
            rectangle = below[below_starts[block] : below_starts[block + 1]].reshape(height, width)
            np.dot(rectangle.T, below_values, block_values)
        else:
            block_values[:] = 0.0
        for row in range(width):
            for lane in range(lanes):
                block_values[row, lane] = (
                    values[first + row, lane] * inverse_diagonal[first + row] - block_values[row, lane]
                )
        triangle = corners[corner_starts[block] : corner_starts[block + 1]].reshape(width, width)
        np.dot(triangle.T, block_values, values[first:end])
