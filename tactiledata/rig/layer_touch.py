"""Contact of a rigid body with a surface that yields linearly: the inner problem of each round of the layer solver."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.rig.layer_friction import Grip, Tractions, linearised
from tactiledata.rig.layer_gap import TouchPoints

Array = NDArray[np.floating[Any]]
Yield = Callable[[Array], Array]
"""Surface displacements (3, rows, columns) under surface forces of that shape."""
Body = Callable[[Array], tuple[Array, Array]]
"""Gaps (n,) and normals (n, 3) at points (n, 3)."""

ROUNDS = 2
"""Newton's steps a call: the outer rounds go on where these end."""
CONJUGATE_STEPS = 60
TOLERANCE = 1e-2
"""Of the conjugate gradients, relative to what is left to correct."""


@dataclass(frozen=True)
class Touching:
    """Contact found.

    Parameters
    ----------
    tractions : (n, 3), Pa
        On the gel.
    force : (3, rows, columns), N
        The same, handed to the grid.
    gap : (n,), m
    points : (n, 3), m
        Where the touch points are now.
    is_slipping : bool
        Whether all that touches slides.
    """

    tractions: Array
    force: Array
    gap: Array
    points: Array
    is_slipping: bool


class Surface:
    """Touch points of a yielding surface."""

    def __init__(self, points: TouchPoints, yields: Yield, shape: tuple[int, int]) -> None:
        self.points, self._yields, self._shape = points, yields, shape
        self._gather = points.share.T.tocsr()

    def on_grid(self, values: Array) -> Array:
        """Forces (3, rows, columns), N, of tractions (n, 3)."""
        return (self._gather @ (values * self.points.areas[:, None])).T.reshape(3, *self._shape)

    def at_points(self, displacement: Array) -> Array:
        """Displacements (n, 3) of the points from those of the grid (3, rows, columns)."""
        return self.points.share @ displacement.reshape(3, -1).T

    def moved(self, values: Array) -> Array:
        """Displacements (n, 3) of the points under tractions (n, 3)."""
        return self.at_points(self._yields(self.on_grid(values)))

    def settle(self, offset: Array, start: Array, grip: Grip, body: Body) -> Touching:
        """Contact where the surface, left alone, would be displaced by ``offset`` (3, rows, columns).

        Newton's steps from tractions ``start`` (n, 3); each is a linear system on the touching points, symmetric and
        positive, by conjugate gradients.
        """
        free = self.points.places + self.at_points(offset)
        values, before = start, None
        for left in range(ROUNDS, -1, -1):
            points = free + self.moved(values)
            gap, normal = body(points)
            state = linearised(grip, points, gap, normal, values)
            if left == 0 or (before is not None and state.is_like(before) and _is_near(values, state.values)):
                break
            before = state
            values = values + self._correction(state, values)
        slipping = bool(state.touching.any() and (state.slipping | ~state.touching).all())
        return Touching(values, self.on_grid(values), gap, points, slipping)

    def _correction(self, state: Tractions, values: Array) -> Array:
        """What to add to tractions (n, 3) so that the linearised law and the surface agree."""
        root = state.root
        inverse = root.inverse
        wanted = state.values - values
        # what no spring answers for, such as the traction of points that come free, is taken at once
        sudden = wanted - root @ (inverse @ wanted)
        right = inverse @ wanted - root @ self.moved(sudden)
        solution = np.zeros_like(right)
        residual, search = right, right
        energy = np.sum(residual * residual)
        goal = TOLERANCE * TOLERANCE * energy
        for _ in range(CONJUGATE_STEPS):
            if energy <= goal:
                break
            image = search + root @ self.moved(root @ search)
            length = energy / np.sum(search * image)
            solution += length * search
            residual = residual - length * image
            energy, last = np.sum(residual * residual), energy
            search = residual + energy / last * search
        return sudden + root @ solution


def _is_near(values: Array, others: Array) -> bool:
    return bool(np.abs(others - values).max(initial=0.0) <= 1e-2 * np.abs(values).max(initial=0.0))
