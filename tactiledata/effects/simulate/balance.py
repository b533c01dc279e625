"""The wrench that bends springs and that the gel, moved by them, then answers."""

from __future__ import annotations

from copy import copy

import numpy as np

from tactiledata.arrays import Array, Mask

LEAST_STEP, LARGEST_STEP = 0.02, 2.0


class Balance:
    """Looks for a wrench (n, 6) by the secant method, each component of each frame by itself.

    Its neighbours hardly matter to a frame.

    Parameters
    ----------
    answer : (n, 6)
        What the gel answers while nothing bends; NaN where it does not.
    """

    def __init__(self, answer: Array) -> None:
        self._known = np.isfinite(answer)
        self.felt = bridged(answer, self._known)
        self.largest = float(np.abs(self.felt).max(initial=0.0))
        self._step = np.ones_like(self.felt)
        self._last = self._miss = np.zeros_like(self.felt)
        self._has_missed = False

    def resumed(self) -> Balance:
        """Another search, for what is bent a little otherwise: from where this one ended, with its steps."""
        other = copy(self)
        other._last = other._miss = np.zeros_like(self.felt)
        other._has_missed = False
        return other

    def knows(self, answer: Array) -> bool:
        """Whether the gel answers in the frames in which it answered first."""
        return np.array_equal(np.isfinite(answer), self._known)

    @property
    def missed(self) -> float:
        """By how much the last answer was another wrench than the one that was felt."""
        return float(np.abs(self._miss).max(initial=0.0))

    def measure(self, answer: Array) -> None:
        """The gel answers this to what is ``felt``."""
        away = answer - self.felt
        self._last, self._miss = self._miss, np.where(np.isfinite(away), away, 0.0)

    def move(self) -> None:
        """``felt`` becomes what should be nearer."""
        if self._has_missed:
            fell = self._last - self._miss
            far = np.abs(fell) > 1e-3 * np.abs(self._miss)
            step = np.divide(self._step * self._last, fell, out=np.ones_like(fell), where=far)
            self._step = np.clip(step, LEAST_STEP, LARGEST_STEP)
        self._has_missed = True
        self.felt = bridged(self.felt + self._step * self._miss, self._known)


def bridged(wrench: Array, known: Mask) -> Array:
    """A wrench (n, 6) with what is unknown taken from its neighbours, as what is not simulated bends the arm, too."""
    frames = np.arange(len(wrench))
    columns = [
        column if sure.all() else np.interp(frames, frames[sure], column[sure]) if sure.any() else np.zeros(len(column))
        for column, sure in zip(wrench.T, known.T, strict=True)
    ]
    return np.stack(columns, axis=1)
