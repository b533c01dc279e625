"""Tractions at the touch points: stiff springs against penetration, Coulomb friction that depends on the path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray


@dataclass(frozen=True)
class FrictionState:
    """The contact law's constants, and what friction remembers of the step before.

    Parameters
    ----------
    stiffness : Pa/m
        Stiffness of the springs, normal and tangential: far above the gel's own, so that neither penetration nor
        creep matters.
    gel_stiffness : Pa/m
        The gel's own stiffness: it weighs distances against tractions where touch and slip are decided.
    friction : float
        Coulomb's coefficient.
    held : (n, 3), Pa
        Tractions on the gel at the end of the step before.
    anchor : (n, 3), m, gel frame
        Place of each point if it had moved with the indenter since then.
    fresh : (n,) bool
        Points that were apart from the indenter: they get no friction in this step.
    """

    stiffness: float
    gel_stiffness: float
    friction: float
    held: RealArray
    anchor: RealArray
    fresh: NDArray[np.bool_]


@dataclass(frozen=True)
class Springs:
    """A stiffness matrix (3, 3) at each of n points, in factored form.

    It has one value along the normal, one along a direction in the tangent plane and one across both. A move along the
    normal also gives a traction in that direction, since friction follows pressure.

    Parameters
    ----------
    normal, direction : (n, 3)
        Unit vectors, at right angles to one another.
    values : (3, n), Pa/m
        Stiffness along the normal, along the direction, across both.
    dragged : (n,), Pa/m
        Traction in the direction by a move along the normal.
    """

    normal: RealArray
    direction: RealArray
    values: RealArray
    dragged: RealArray

    def __matmul__(self, vectors: RealArray) -> RealArray:
        """Return the products (n, 3) of the matrices and vectors (n, 3)."""
        up, along, across = self.values
        raised = np.einsum("ij,ij->i", self.normal, vectors)
        on_normal = (up - across) * raised
        on_direction = (along - across) * np.einsum("ij,ij->i", self.direction, vectors) + self.dragged * raised
        return across[:, None] * vectors + on_normal[:, None] * self.normal + on_direction[:, None] * self.direction


@dataclass(frozen=True)
class Tractions:
    """The contact law, linearised about the present places of the points.

    Parameters
    ----------
    values : (n, 3), Pa
        Tractions on the gel, at the points' present places.
    springs : Springs
        Minus the derivative of the tractions by the place.
    touching, slipping : (n,) bool
        Points that touch, and those of them that slip.
    """

    values: RealArray
    springs: Springs
    touching: NDArray[np.bool_]
    slipping: NDArray[np.bool_]

    def is_like(self, other: Tractions) -> bool:
        """Return whether the same points touch and slip in both."""
        return bool((self.touching == other.touching).all() and (self.slipping == other.slipping).all())


def linearised(
    friction_state: FrictionState, points: RealArray, gap: RealArray, normal: RealArray, now: RealArray
) -> Tractions:
    """Return the contact law, linearised about the present places of n touch points.

    It holds the tractions there and, as `Springs`, minus their derivative by the place.

    Touch and slip are decided by distance and traction together, as in the primal-dual active set method: a point
    touches if its pressure exceeds its gap times the gel's stiffness, and slips if stick would need more than
    Coulomb's cone allows.

    Parameters
    ----------
    friction_state : FrictionState
        Constants of the law, and the step before.
    points : (n, 3), m, gel frame
        Present places.
    gap : (n,), m
        Signed distances to the indenter, negative where a point is inside.
    normal : (n, 3)
        Unit normals out of the indenter.
    now : (n, 3), Pa
        Present tractions on the gel.
    """
    # which points touch, and which of them slip
    pressure = np.einsum("ij,ij->i", now, normal)
    touching = pressure - friction_state.gel_stiffness * gap > 0
    move = points - friction_state.anchor
    move -= np.einsum("ij,ij->i", move, normal)[:, None] * normal
    held = friction_state.held - np.einsum("ij,ij->i", friction_state.held, normal)[:, None] * normal
    trial = now - pressure[:, None] * normal - friction_state.gel_stiffness * move
    size = np.linalg.norm(trial, axis=1)
    cone = np.where(friction_state.fresh, 0.0, friction_state.friction * np.maximum(pressure, 0.0))
    slipping = touching & (size > cone)
    sticking = touching & ~slipping
    direction = np.where((size > 0)[:, None], trial / np.maximum(size, 1e-30)[:, None], 0.0)
    share = np.minimum(cone / np.maximum(size, 1e-30), 1.0 - friction_state.gel_stiffness / friction_state.stiffness)
    # in slip the traction turns with the move across it
    turning = np.where(slipping, friction_state.gel_stiffness * share / (1.0 - share), 0.0)
    move_across = move - np.einsum("ij,ij->i", move, direction)[:, None] * direction
    # tractions and their derivatives
    push = np.where(touching, -friction_state.stiffness * gap, 0.0)
    dragging = slipping & ~friction_state.fresh & (push > 0)
    pull = np.where(dragging, friction_state.friction * push, 0.0)
    values = push[:, None] * normal
    values += np.where(sticking[:, None], held - friction_state.stiffness * move, 0.0)
    values += np.where(slipping[:, None], pull[:, None] * direction - turning[:, None] * move_across, 0.0)
    along = np.where(sticking, friction_state.stiffness, 0.0)
    springs = np.stack([np.where(touching, friction_state.stiffness, 0.0), along, along + turning])
    dragged = np.where(dragging, friction_state.friction * friction_state.stiffness, 0.0)
    return Tractions(values, Springs(normal, direction, springs, dragged), touching, slipping)
