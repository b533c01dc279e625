"""Tractions at the touch points: stiff springs against penetration, Coulomb stick and slip that remember their path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray


@dataclass(frozen=True)
class FrictionState:
    """The law at one step.

    Parameters
    ----------
    stiffness : Pa/m
        Of the springs, normal and tangential: far above the gel's own, so that neither penetration nor creep counts.
    gel_stiffness : Pa/m
        The gel's own: weighs distances against tractions where touch and slip are decided.
    friction : Coulomb's coefficient
    held : (n, 3), Pa
        Tractions on the gel at the end of the step before.
    anchor : (n, 3), m, gel frame
        Where a point would be that had moved with the indenter since then.
    fresh : (n,) bool
        Points that were apart from the indenter: they come without friction, which begins with the next step.
    """

    stiffness: float
    gel_stiffness: float
    friction: float
    held: RealArray
    anchor: RealArray
    fresh: NDArray[np.bool_]


@dataclass(frozen=True)
class Springs:
    """At each point a matrix: one value along the normal, one along a direction in the plane, one across, and what a
    move along the normal does in that direction, as friction follows pressure.

    Parameters
    ----------
    normal, direction : (n, 3)
        Unit vectors, at right angles to one another.
    values : (3, n)
        Along the normal, along the direction, across both.
    dragged : (n,)
        In the direction, of a move along the normal.
    """

    normal: RealArray
    direction: RealArray
    values: RealArray
    dragged: RealArray

    def __matmul__(self, vectors: RealArray) -> RealArray:
        """The matrices times vectors (n, 3)."""
        up, along, across = self.values
        raised = np.einsum("ij,ij->i", self.normal, vectors)
        on_normal = (up - across) * raised
        on_direction = (along - across) * np.einsum("ij,ij->i", self.direction, vectors) + self.dragged * raised
        return across[:, None] * vectors + on_normal[:, None] * self.normal + on_direction[:, None] * self.direction


@dataclass(frozen=True)
class Tractions:
    """The law, made linear.

    Parameters
    ----------
    values : (n, 3), Pa
        On the gel, at the points' present places.
    springs : Springs
        Minus their derivative by the place.
    touching, slipping : (n,) bool
    """

    values: RealArray
    springs: Springs
    touching: NDArray[np.bool_]
    slipping: NDArray[np.bool_]

    def is_like(self, other: Tractions) -> bool:
        """Whether the same points touch and slip."""
        return bool((self.touching == other.touching).all() and (self.slipping == other.slipping).all())


def linearised(
    friction_state: FrictionState, points: RealArray, gap: RealArray, normal: RealArray, now: RealArray
) -> Tractions:
    """The law about points (n, 3) with gaps (n,), normals (n, 3) out of the indenter and present tractions (n, 3).

    Touch and slip are decided by distance and traction together, as in the primal-dual active set method: a point
    touches if it presses more than it is apart, and slips if stick would need more than the cone holds.
    """
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
