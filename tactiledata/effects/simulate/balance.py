"""Force balance between springs and the gel: the wrench that bends the springs is the one that the gel answers."""

from __future__ import annotations

from copy import copy

import numpy as np

from tactiledata.arrays import Array, Mask

LEAST_STEP, LARGEST_STEP = 0.02, 2.0
"""Limits of the secant step, as a factor on the residual."""


class Balance:
    """Secant iteration for the wrench (n, 6) in balance, each component of each frame on its own.

    The components hardly depend on one another. ``felt`` is the current estimate, ``largest`` the largest component of
    the first answer, N or N m.

    Parameters
    ----------
    answer : (n, 6) N, N m
        Answer of the gel while nothing bends; NaN where the gel could not be solved.
    """

    def __init__(self, answer: Array) -> None:
        self._known = np.isfinite(answer)
        self.felt = bridged(answer, self._known)
        self.largest = float(np.abs(self.felt).max(initial=0.0))
        self._step = np.ones_like(self.felt)
        self._last = self._miss = np.zeros_like(self.felt)
        self._has_missed = False

    def resumed(self) -> Balance:
        """Return an iteration that starts from the result and the steps of this one, for a slightly changed touch."""
        other = copy(self)
        other._last = other._miss = np.zeros_like(self.felt)
        other._has_missed = False
        return other

    def knows(self, answer: Array) -> bool:
        """Whether the gel answers in the same frames as at the start."""
        return np.array_equal(np.isfinite(answer), self._known)

    @property
    def missed(self) -> float:
        """Largest residual: component of the last answer less the wrench that it was asked for, N or N m."""
        return float(np.abs(self._miss).max(initial=0.0))

    def measure(self, answer: Array) -> None:
        """Record the answer (n, 6) of the gel to the current estimate ``felt``."""
        away = answer - self.felt
        self._last, self._miss = self._miss, np.where(np.isfinite(away), away, 0.0)

    def move(self) -> None:
        """Replace the estimate ``felt`` by the next one of the secant method."""
        if self._has_missed:
            fell = self._last - self._miss
            far = np.abs(fell) > 1e-3 * np.abs(self._miss)
            step = np.divide(self._step * self._last, fell, out=np.ones_like(fell), where=far)
            self._step = np.clip(step, LEAST_STEP, LARGEST_STEP)
        self._has_missed = True
        self.felt = bridged(self.felt + self._step * self._miss, self._known)


def bridged(wrench: Array, known: Mask) -> Array:
    """Return a wrench (n, 6) whose unknown entries are interpolated in time; 0 in a column without known entries.

    Frames that could not be simulated bend the arm all the same.
    """
    frames = np.arange(len(wrench))
    columns = [
        column if sure.all() else np.interp(frames, frames[sure], column[sure]) if sure.any() else np.zeros(len(column))
        for column, sure in zip(wrench.T, known.T, strict=True)
    ]
    return np.stack(columns, axis=1)
