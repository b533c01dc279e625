"""Anderson's mixing: the next guess of a fixed point from the last few guesses and what became of them."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import RealArray

MEMORY = 4
"""Differences that are kept."""
RIDGE = 1e-9
"""Of the least squares, relative."""
LARGEST = 1.5e-4
"""m: no guess goes further from the one before."""


class Mixing:
    """Accelerates x -> g(x), where the error g(x) - x is what a linear layer makes of a load.

    Errors are weighed by the energy of that layer, the product of error and load: small cells at a rim count as they
    should, which the sum of squares would drown in the bulk.
    """

    def __init__(self) -> None:
        self._steps: list[RealArray] = []
        self._changes: list[RealArray] = []
        self._loads: list[RealArray] = []
        self._gram = np.zeros((0, 0))
        self._last: tuple[RealArray, RealArray, RealArray] | None = None

    def next(self, x: RealArray, error: RealArray, load: RealArray) -> RealArray:
        """The guess after ``x``."""
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
