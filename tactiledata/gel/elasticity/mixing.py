"""Anderson acceleration of a fixed-point iteration, with a memory that outlasts one load step."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array, Indices

MEMORY = 60
"""Number of differences kept: the tangent changes little between load steps, so old differences stay useful."""
REGULARISATION = 1e-10
"""Regularisation relative to the mean squared difference; it keeps nearly parallel differences from cancelling."""


class SecantMixer:
    """Anderson's method that keeps the differences of earlier load steps.

    Sources: H. F. Walker and P. Ni, SIAM J. Numer. Anal. 49 (2011); reuse of steps as in J. Degroote, K.-J. Bathe and
    J. Vierendeels, Comput. Struct. 87 (2009).

    Parameters
    ----------
    size : int
        Number of unknowns.
    measured : (k,)
        Places of the unknowns that enter the residual; the others follow with the same weights.
    """

    def __init__(self, size: int, measured: Indices) -> None:
        # images of the map are only summed, so single precision is enough
        self._leads = np.zeros((MEMORY, size), dtype=np.float32)
        self._changes = np.zeros((MEMORY, len(measured)))
        self._gram = np.zeros((MEMORY, MEMORY))
        self._measured = measured
        self._filled = 0
        self._next = 0
        self._last: tuple[Array, Array] | None = None

    def start_step(self) -> None:
        """Start another load step: the next point forms no difference with the last one."""
        self._last = None

    def forget(self) -> None:
        """Drop all differences."""
        self._filled = self._next = 0
        self._last = None

    def mix(self, point: Array, image: Array) -> Array:
        """Return the next point (size,), from a point (size,) and its image (size,) under the fixed-point map."""
        residual = (image - point)[self._measured]
        if self._last is not None:
            self._remember(image - self._last[0], residual - self._last[1])
        self._last = (image, residual)
        if not self._filled:
            return image
        # weights of the kept differences that minimise the residual
        kept = slice(0, self._filled)
        gram = self._gram[kept, kept]
        damped = gram + np.eye(self._filled) * (REGULARISATION * np.trace(gram) / self._filled)
        weights = np.linalg.solve(damped, self._changes[kept] @ residual)
        mixed: Array = image - weights.astype(np.float32) @ self._leads[kept]
        return mixed

    def _remember(self, image_difference: Array, residual_difference: Array) -> None:
        """Replace the oldest difference, and update the inner products of residual differences."""
        place = self._next
        self._leads[place], self._changes[place] = image_difference, residual_difference
        self._next = (place + 1) % MEMORY
        self._filled = max(self._filled, place + 1)
        products = self._changes[: self._filled] @ residual_difference
        self._gram[place, : self._filled] = products
        self._gram[: self._filled, place] = products
