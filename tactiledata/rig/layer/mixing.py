"""Anderson's mixing: the next guess of a fixed point from the last few guesses and their errors."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import RealArray

MEMORY = 4
"""Number of differences that are kept."""
RIDGE = 1e-9
"""Ridge of the least squares, relative to the trace."""
LARGEST = 1.5e-4
"""Largest change of a displacement from one guess to the next, m."""


class Mixing:
    """Accelerates the iteration x -> g(x), whose error g(x) - x is a linear layer's displacement under a load.

    Errors are weighed by the energy of that layer, the product of error and load: in a sum of squares, small cells at
    a rim would not count beside the bulk.
    """

    def __init__(self) -> None:
        self._steps: list[RealArray] = []
        self._changes: list[RealArray] = []
        self._loads: list[RealArray] = []
        self._gram = np.zeros((0, 0))
        self._last: tuple[RealArray, RealArray, RealArray] | None = None

    def next(self, x: RealArray, error: RealArray, load: RealArray) -> RealArray:
        """Return the guess that follows ``x``.

        Parameters
        ----------
        x : (3, levels, rows, columns), m
            The present guess.
        error : same shape, m
            Its error g(x) - x.
        load : same shape, N
            The load whose displacement in the linear layer is the error.
        """
        if self._last is not None:
            self._remember(*(now - then for now, then in zip((x, error, load), self._last, strict=True)))
        self._last = x, error, load
        guess = x + error
        if self._changes:
            ridge = RIDGE * np.trace(self._gram) * np.eye(len(self._gram))
            shares = np.linalg.solve(self._gram + ridge, [np.sum(change * load) for change in self._changes])
            for share, step, change in zip(shares, self._steps, self._changes, strict=True):
                guess -= share * (step + change)
        leap = np.abs(guess - x).max() / LARGEST
        return guess if leap <= 1.0 else x + (guess - x) / leap

    def _remember(self, step: RealArray, change: RealArray, load: RealArray) -> None:
        """Keep the differences of guess, error and load to the ones before, and drop the oldest."""
        self._steps.append(step)
        self._changes.append(change)
        self._loads.append(load)
        size = len(self._changes)
        gram = np.empty((size, size))
        gram[:-1, :-1] = self._gram
        # sums, not library products: those differ with the number of threads
        gram[-1] = gram[:, -1] = [np.sum(change * other) for other in self._loads]
        if size > MEMORY:
            del self._steps[0], self._changes[0], self._loads[0]
            gram = gram[1:, 1:]
        self._gram = gram
