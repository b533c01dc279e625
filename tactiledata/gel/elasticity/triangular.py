"""Factor of a sparse symmetric matrix in single precision, with columns gathered into dense blocks."""

from __future__ import annotations

from collections import deque
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial

import numpy as np
from numba import njit
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
        pointers, numbers = lower.indptr.astype(np.int64), lower.indices.astype(np.int64)
        starts = _block_starts(pointers, numbers)
        widths = np.diff(starts)
        # rows below the diagonal block are those of the block's last column
        heights = pointers[starts[1:]] - pointers[starts[1:] - 1] - 1
        row_starts, below_starts, corner_starts = (_ends(sizes) for sizes in (heights, heights * widths, widths**2))
        rows = np.empty(row_starts[-1], np.int64)
        below, corners = np.empty(below_starts[-1], np.float32), np.empty(corner_starts[-1], np.float32)
        _gather(
            pointers, numbers, lower.data, starts, rows, row_starts, below, below_starts, corners, corner_starts
        )  # fmt: skip
        return BlockFactor(
            factor.perm_c.astype(np.int64),
            starts,
            rows,
            row_starts,
            below,
            below_starts,
            corners,
            corner_starts,
            (1.0 / factor.U.diagonal()).astype(np.float32),
        )

    def solve(self, right: Array, threads: Executor | None = None, lanes: int = LANES) -> Array:
        """Return solutions (b, n) of right-hand sides (b, n).

        Parameters
        ----------
        right : (b, n)
            Right-hand sides.
        threads : Executor, optional
            Threads on which the groups run.
        lanes : int
            Right-hand sides of a group. The factor is read once for each group: many lanes are fast for many
            right-hand sides, one is fast for one. Other lanes round otherwise.
        """
        solution = np.empty(right.shape)
        shares = [slice(first, first + lanes) for first in range(0, len(right), lanes)]
        solve_some = partial(self._solve_some, right, solution, lanes)
        deque((map if threads is None else threads.map)(solve_some, shares), maxlen=0)
        return solution

    def _solve_some(self, right: Array, solution: Array, lanes: int, share: slice) -> None:
        """Write the solutions of one group of right-hand sides (b, n) to the same rows of ``solution``."""
        part = right[share]
        work = np.zeros((right.shape[1], lanes), dtype=np.float32)
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


def _ends(sizes: Indices) -> Indices:
    """Places (s + 1,) at which each part starts, and the last ends, when parts of these sizes (s,) are concatenated."""
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


@njit(nogil=True, cache=True)
def _block_starts(starts: Indices, rows: Indices) -> Indices:
    """First columns of runs of columns with the same pattern, and the number of columns at the end.

    ``starts`` and ``rows`` are the column pointers and row numbers of L, rows ascending.
    """
    columns = len(starts) - 1
    firsts = np.empty(columns + 1, np.int64)
    count = 1
    firsts[0] = 0
    for column in range(1, columns):
        before, here, end = starts[column - 1] + 1, starts[column], starts[column + 1]
        is_same = here - before == end - here
        place = 0
        while is_same and place < end - here:
            is_same = rows[before + place] == rows[here + place]
            place += 1
        if not is_same:
            firsts[count] = column
            count += 1
    firsts[count] = columns
    return firsts[: count + 1]


@njit(nogil=True, cache=True)
def _gather(
    pointers: Indices,
    numbers: Indices,
    values: Array,
    starts: Indices,
    rows: Indices,
    row_starts: Indices,
    below: SingleArray,
    below_starts: Indices,
    corners: SingleArray,
    corner_starts: Indices,
) -> None:
    """Write the rows, the values below the triangles and the inverse triangles of all blocks of L.

    Parameters
    ----------
    pointers, numbers, values : (n + 1,), (z,), (z,)
        L as columns, rows ascending.
    starts : (s + 1,)
        First column of each block.
    rows, row_starts, below, below_starts, corners, corner_starts
        Results and their places, as in `BlockFactor`.
    """
    for block in range(len(starts) - 1):
        first, end = starts[block], starts[block + 1]
        width, height = end - first, row_starts[block + 1] - row_starts[block]
        last = pointers[end - 1] + 1
        for row in range(height):
            rows[row_starts[block] + row] = numbers[last + row]
        triangle, inverse = np.eye(width), np.eye(width)
        for place in range(width):
            column = pointers[first + place]
            for row in range(width - place):
                triangle[place + row, place] = values[column + row]
            for row in range(height):
                below[below_starts[block] + row * width + place] = values[column + width - place + row]
        # inverse of a unit triangle, column by column
        for column in range(width):
            for row in range(column + 1, width):
                total = 0.0
                for inner in range(column, row):
                    total += triangle[row, inner] * inverse[inner, column]
                inverse[row, column] = -total
        for row in range(width):
            for column in range(width):
                corners[corner_starts[block] + row * width + column] = inverse[row, column]


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
        # unit loads leave most of the first blocks without any
        if not np.any(values[first:end]):
            continue
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
