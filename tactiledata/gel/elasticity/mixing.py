"""Anderson acceleration of a fixed point whose memory outlives one load step."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array, Indices

MEMORY = 60
"""Differences kept: the tangent changes little from one load step to the next, so that old ones still serve."""
REGULARISATION = 1e-10
"""Relative to the mean squared difference; keeps nearly parallel differences from cancelling."""


class SecantMixer:
    """Anderson's method with differences of earlier steps kept.

    Sources: H. F. Walker and P. Ni, SIAM J. Numer. Anal. 49 (2011); reuse of steps as in J. Degroote, K.-J. Bathe and
    J. Vierendeels, Comput. Struct. 87 (2009).

    Parameters
    ----------
    size : int
        Length of the unknowns.
    measured : (k,)
        Those of them that the residual is measured by; the others only follow along.
    """

    def __init__(self, size: int, measured: Indices) -> None:
        # where the fixed point's map leads is only added up, so that single precision serves
        self._leads = np.zeros((MEMORY, size), dtype=np.float32)
        self._changes = np.zeros((MEMORY, len(measured)))
        self._gram = np.zeros((MEMORY, MEMORY))
        self._measured = measured
        self._filled = 0
        self._next = 0
        self._last: tuple[Array, Array] | None = None

    def start_step(self) -> None:
        """The next point belongs to another load step: no difference with the last one."""
        self._last = None

    def forget(self) -> None:
        """Drop everything."""
        self._filled = self._next = 0
        self._last = None

    def mix(self, point: Array, reached: Array) -> Array:
        """The next point (size,), from a point and what the fixed point's map made of it."""
        residual = (reached - point)[self._measured]
        if self._last is not None:
            self._remember(reached - self._last[0], residual - self._last[1])
        self._last = (reached, residual)
        if not self._filled:
            return reached
        kept = slice(0, self._filled)
        gram = self._gram[kept, kept]
        damped = gram + np.eye(self._filled) * (REGULARISATION * np.trace(gram) / self._filled)
        weights = np.linalg.solve(damped, self._changes[kept] @ residual)
        mixed: Array = reached - weights.astype(np.float32) @ self._leads[kept]
        return mixed

    def _remember(self, lead: Array, change: Array) -> None:
        place = self._next
        self._leads[place], self._changes[place] = lead, change
        self._next = (place + 1) % MEMORY
        self._filled = max(self._filled, place + 1)
        products = self._changes[: self._filled] @ change
        self._gram[place, : self._filled] = products
        self._gram[: self._filled, place] = products
