"""Contact of a rigid body with a surface that yields linearly: the inner problem of each round of the layer solver."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import RealArray
from tactiledata.rig.layer.friction import FrictionState, Tractions, linearised
from tactiledata.rig.layer.gap import TouchPoints

Yield = Callable[[RealArray], RealArray]
"""Surface displacements (3, rows, columns) under surface forces of that shape."""
Body = Callable[[RealArray], tuple[RealArray, RealArray]]
"""Gaps (n,) and normals (n, 3) at points (n, 3)."""

ROUNDS = 6
"""Newton's steps a call: the outer rounds go on where these end."""
KRYLOV_STEPS = 60
TOLERANCE = 3e-2
"""Of GMRES, relative to what is left to correct."""


@dataclass(frozen=True)
class SurfaceContact:
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

    tractions: RealArray
    force: RealArray
    gap: RealArray
    points: RealArray
    is_slipping: bool


class Surface:
    """Touch points of a yielding surface."""

    def __init__(self, points: TouchPoints, yields: Yield, shape: tuple[int, int]) -> None:
        self.points, self._yields, self._shape = points, yields, shape
        self._gather = points.share.T.tocsr()

    def on_grid(self, values: RealArray) -> RealArray:
        """Forces (3, rows, columns), N, of tractions (n, 3)."""
        return (self._gather @ (values * self.points.areas[:, None])).T.reshape(3, *self._shape)

    def at_points(self, displacement: RealArray) -> RealArray:
        """Displacements (n, 3) of the points from those of the grid (3, rows, columns)."""
        return self.points.share @ displacement.reshape(3, -1).T

    def settle(
        self, offset: RealArray, values: RealArray, force: RealArray, friction_state: FrictionState, body: Body
    ) -> SurfaceContact:
        """Contact where the surface, left alone, would be displaced by ``offset`` (3, rows, columns).

        Newton's steps from tractions ``values`` (n, 3) that are handed to the grid as ``force`` (3, rows, columns).
        """
        before = None
        points = self.points.places + self.at_points(offset + self._yields(force))
        for left in range(ROUNDS, -1, -1):
            gap, normal = body(points)
            state = linearised(friction_state, points, gap, normal, values)
            if left == 0 or (before is not None and state.is_like(before) and _is_near(values, state.values)):
                break
            before = state
            more, move = self._correction(state, self.on_grid(state.values) - force)
            step = self.at_points(move)
            # the grid's forces are not those of the springs: these multiply what the iteration leaves open
            values, force, points = state.values - state.springs @ step, force + more, points + step
        slipping = bool(state.touching.any() and (state.slipping | ~state.touching).all())
        return SurfaceContact(values, force, gap, points, slipping)

    def _correction(self, state: Tractions, missing: RealArray) -> tuple[RealArray, RealArray]:
        """Forces, and the moves they make, both (3, rows, columns), that bring law and surface together.

        Forces f on the grid obey f + G C f = ``missing``, with C the surface's compliance and G the springs, seen from
        the grid: GMRES in the product weighed by C, which needs one C a step.
        """
        move = self._yields(missing)
        size = np.sqrt(np.sum(missing * move))
        if size == 0.0:
            return np.zeros_like(missing), np.zeros_like(missing)
        forces, moves = [missing / size], [move / size]
        shares = np.zeros((KRYLOV_STEPS + 1, KRYLOV_STEPS))
        for step in range(KRYLOV_STEPS):
            image = forces[step] + self.on_grid(state.springs @ self.at_points(moves[step]))
            for place, other in enumerate(moves):
                shares[place, step] = np.sum(image * other)
                image = image - shares[place, step] * forces[place]
            move = self._yields(image)
            left = np.sqrt(max(np.sum(image * move), 0.0))
            shares[step + 1, step] = left
            weights, deviation = _least(shares[: step + 2, : step + 1], size)
            if deviation <= TOLERANCE * size or left == 0.0:
                break
            forces.append(image / left)
            moves.append(move / left)
        # not a library product: those differ with the number of threads
        found, made = (np.einsum("k,kcij->cij", weights, np.stack(parts[: len(weights)])) for parts in (forces, moves))
        return found, made


def _least(shares: RealArray, size: float) -> tuple[RealArray, float]:
    """Weights of GMRES's basis, and what they miss."""
    goal = np.zeros(len(shares))
    goal[0] = size
    weights = np.linalg.lstsq(shares, goal, rcond=None)[0]
    return weights, float(np.linalg.norm(goal - shares @ weights))


def _is_near(values: RealArray, others: RealArray) -> bool:
    return bool(np.abs(others - values).max(initial=0.0) <= 1e-2 * np.abs(values).max(initial=0.0))
