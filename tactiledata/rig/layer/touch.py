"""Contact of a rigid body with a linearly elastic surface: the inner problem of each round of the layer solver."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import RealArray
from tactiledata.rig.layer.friction import FrictionState, Tractions, linearised
from tactiledata.rig.layer.gap import TouchPoints

Yield = Callable[[RealArray], RealArray]
"""Function that gives surface displacements (3, rows, columns), m, under surface forces of that shape, N."""
Body = Callable[[RealArray], tuple[RealArray, RealArray]]
"""Function that gives gaps (n,), m, and normals (n, 3) at points (n, 3), m."""

ROUNDS = 6
"""Largest number of Newton steps in a call; the outer rounds continue from where they end."""
KRYLOV_STEPS = 60
"""Largest number of GMRES steps in a Newton step."""
TOLERANCE = 3e-2
"""Relative tolerance of GMRES."""


@dataclass(frozen=True)
class SurfaceContact:
    """The contact of a surface with a body, as the Newton steps found it.

    Parameters
    ----------
    tractions : (n, 3), Pa
        Tractions on the gel at the touch points.
    force : (3, rows, columns), N
        Forces of these tractions on the grid.
    gap : (n,), m
        Signed distances of the touch points from the body.
    points : (n, 3), m
        Present places of the touch points.
    is_slipping : bool
        Whether all that touches slides.
    """

    tractions: RealArray
    force: RealArray
    gap: RealArray
    points: RealArray
    is_slipping: bool


class Surface:
    """The touch points of a linearly elastic surface.

    Parameters
    ----------
    points : TouchPoints
        The points, on the undeformed surface.
    yields : callable
        Gives the surface's displacements under forces on the grid.
    shape : (rows, columns)
        Shape of the grid.
    """

    def __init__(self, points: TouchPoints, yields: Yield, shape: tuple[int, int]) -> None:
        self.points, self._yields, self._shape = points, yields, shape
        self._gather = points.share.T.tocsr()

    def on_grid(self, values: RealArray) -> RealArray:
        """Return the forces on the grid (3, rows, columns), N, of tractions (n, 3), Pa."""
        return (self._gather @ (values * self.points.areas[:, None])).T.reshape(3, *self._shape)

    def at_points(self, displacement: RealArray) -> RealArray:
        """Return the displacements of the points (n, 3), m, from those of the grid (3, rows, columns)."""
        return self.points.share @ displacement.reshape(3, -1).T

    def settle(
        self, offset: RealArray, values: RealArray, force: RealArray, friction_state: FrictionState, body: Body
    ) -> SurfaceContact:
        """Return the contact of the surface with a body, by Newton steps on the contact law.

        Parameters
        ----------
        offset : (3, rows, columns), m
            Displacements of the surface without contact.
        values : (n, 3), Pa
            Tractions to begin with.
        force : (3, rows, columns), N
            Forces of these tractions on the grid.
        friction_state : FrictionState
            Constants of the contact law, and the step before.
        body : callable
            Gives gaps and normals of the body at points.
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
            # the grid keeps the forces of GMRES: the stiff springs would multiply its remaining error
            values, force, points = state.values - state.springs @ step, force + more, points + step
        slipping = bool(state.touching.any() and (state.slipping | ~state.touching).all())
        return SurfaceContact(values, force, gap, points, slipping)

    def _correction(self, state: Tractions, missing: RealArray) -> tuple[RealArray, RealArray]:
        """Return forces, N, and their displacements, m, both (3, rows, columns), that correct a missing force.

        Forces f on the grid obey f + G C f = ``missing``, with C the surface's compliance and G the springs, seen from
        the grid. GMRES uses the inner product of C, so that each step evaluates C once.
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
            weights, remainder = _least(shares[: step + 2, : step + 1], size)
            if remainder <= TOLERANCE * size or left == 0.0:
                break
            forces.append(image / left)
            moves.append(move / left)
        # not a library product: those differ with the number of threads
        force, move = (np.einsum("k,kcij->cij", weights, np.stack(parts[: len(weights)])) for parts in (forces, moves))
        return force, move


def _least(shares: RealArray, size: float) -> tuple[RealArray, float]:
    """Return the least-squares weights (k,) of GMRES's basis, and the norm of the remainder."""
    goal = np.zeros(len(shares))
    goal[0] = size
    weights = np.linalg.lstsq(shares, goal, rcond=None)[0]
    return weights, float(np.linalg.norm(goal - shares @ weights))


def _is_near(values: RealArray, others: RealArray) -> bool:
    """Return whether tractions differ by at most 1 % of the largest."""
    return bool(np.abs(others - values).max(initial=0.0) <= 1e-2 * np.abs(values).max(initial=0.0))
