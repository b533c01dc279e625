"""A rigid body pressed into an elastic layer step by step: finite strain, contact, friction that depends on the path.

Each step is a fixed point. For known displacements of the layer, its internal forces are out of balance; a linear layer
removes the imbalance and, at its surface, meets the indenter exactly (`touch`). The imbalance that remains, since the
true layer is not linear, is left to the next round; Anderson's mixing makes the rounds few. The linear layer is stiffer
than the material: large strain stiffens, and a preconditioner that is too soft overshoots.

Not to be confused with `tactiledata.rig.contact.closed_form`, the closed forms that the rig can use instead.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tactiledata.arrays import RealArray
from tactiledata.indenters.base import Indenter
from tactiledata.rig.layer.friction import FrictionState
from tactiledata.rig.layer.gap import TouchPoints, gaps, gaps_and_normals
from tactiledata.rig.layer.grid import Column, LayerGrid
from tactiledata.rig.layer.kernel import LayerKernel
from tactiledata.rig.layer.mixing import Mixing
from tactiledata.rig.layer.strain import LayerStrain
from tactiledata.rig.layer.touch import Surface, SurfaceContact
from tactiledata.rig.scenario.scenario import Material

Fall = Callable[[RealArray, RealArray], RealArray]
"""Function that gives how much lower a surface lies, m, at places x, y, m."""

SPRINGS = 20.0
"""Stiffness of the contact's springs relative to the surface's own at the scale of a cell."""
REACH = 4e-4
"""Distance from the indenter, m, within which touch points take part in a step."""
TOUCHED = 1e-6
"""Gap, m, below which a point counts as touched already."""
STIFFER_SHEAR, STIFFER_VOLUME = 8.0, 2.0
"""Lamé's constants of the linear layer relative to the material's: measured, docs/decisions/0007."""
ROUNDS = 30
"""Largest number of rounds of a step."""
TOLERANCE = 2e-3
"""Relative change of the force between rounds at which a step is done."""
MOVE_SHARE = 1.5e-3
"""Length, m, whose product with the tolerance is the change of the surface at which a step is done."""
LEAST_FORCE = 2e-4
"""Change of the force, N, that never matters."""
UNSETTLED = 2e-5
"""Change of the surface, m, in the last round beyond which a step is taken again in two halves."""
HALVINGS = 2
"""Number of times that a step may be halved."""


@dataclass(frozen=True)
class PressState:
    """The layer at the end of a step.

    Parameters
    ----------
    u : (3, levels, rows, columns), m
        Displacements of the nodes.
    traction : (n, 3), Pa
        Tractions on the gel, at all touch points.
    gap : (n,), m
        Signed distances of the touch points from the indenter; ``inf`` far from it.
    points : (n, 3), m
        Present places of the touch points.
    pose : (4, 4)
        Pose of the indenter, gel_from_indenter.
    wrench : (6,), N, N m
        Wrench on the indenter, about the gel's origin.
    is_slipping : bool
        Whether all that touches slides.
    is_settled : bool
        Whether the rounds converged.
    """

    u: RealArray
    traction: RealArray
    gap: RealArray
    points: RealArray
    pose: RealArray
    wrench: RealArray
    is_slipping: bool = False
    is_settled: bool = True

    @property
    def is_touching(self) -> bool:
        """Whether any touch point carries a traction."""
        return bool(self.traction.any())


class Layer:
    """A pad that can be pressed; what is the same for every press is computed once.

    Parameters
    ----------
    grid : LayerGrid
        Points in the plane.
    thickness : metres
        Thickness of the pad.
    material : Material
        The gel's material.
    is_linear : bool
        Whether strain is taken as small, for comparison.
    tolerance : float
        Relative change of the force between rounds at which a step is done.
    """

    def __init__(
        self,
        grid: LayerGrid,
        thickness: float,
        material: Material,
        is_linear: bool = False,
        tolerance: float = TOLERANCE,
    ) -> None:
        shear, lame = lame_constants(material)
        column = Column.of(thickness, grid.pitch)
        self.grid, self.material = grid, material
        self._tolerance = tolerance
        factors = (1.0, 1.0) if is_linear else (STIFFER_SHEAR, STIFFER_VOLUME)
        self._kernel = LayerKernel(grid, column, factors[0] * shear, factors[1] * lame)
        self._strain = LayerStrain(grid, column, shear, lame, is_linear)
        self._points = TouchPoints.of(grid)
        self._heights = np.zeros(grid.shape)
        self._levels = len(column.slope[0])
        self._gel_stiffness = material.youngs_modulus / (1 - material.poisson_ratio**2) / grid.pitch

    def lowered(self, fall: Fall) -> Layer:
        """Return this layer with a surface that lies lower by a function of the place.

        Contact is looked for at that surface; inside, the layer is as thick as before everywhere.
        """
        other = copy(self)
        other._points = self._points.lowered(fall(*self._points.places[:, :2].T))
        other._heights = self._heights - fall(*np.meshgrid(self.grid.x, self.grid.y))
        return other

    def at_rest(self, indenter: Indenter, pose: RealArray) -> PressState:
        """Return the state before a touch, with the indenter lifted from ``pose`` along gel z until it is clear."""
        clear, places = pose.copy(), self._points.places
        gap = gaps(indenter, clear, places)
        for _ in range(60):
            if gap.min() >= -TOUCHED / 10:
                break
            clear[2, 3] -= gap.min()
            gap = gaps(indenter, clear, places)
        flat = np.zeros((3, self._levels, *self.grid.shape))
        return PressState(flat, np.zeros_like(places), gap, places, clear, np.zeros(6))

    def step(
        self,
        indenter: Indenter,
        before: PressState,
        pose: RealArray,
        guess: RealArray | None = None,
        halvings: int = HALVINGS,
    ) -> PressState:
        """Return the state with the indenter at a new pose, reached in one small step.

        Parameters
        ----------
        indenter : Indenter
            The body.
        before : PressState
            State at the end of the step before.
        pose : (4, 4), metres
            New pose of the indenter, gel_from_indenter.
        guess : (3, levels, rows, columns), m, optional
            Displacements to begin with; those of ``before`` where not given.
        halvings : int
            Number of times that a step that does not converge may be halved.
        """
        if gaps(indenter, pose, self._points.places).min() >= -TOUCHED:
            return self.at_rest(indenter, pose)
        if not before.is_touching:
            before = self.at_rest(indenter, pose)
        after = self._settled(indenter, before, pose, before.u if guess is None else guess)
        if after.is_settled or halvings == 0:
            return after
        middle = self.step(indenter, before, _between(before.pose, pose), None, halvings - 1)
        return self.step(indenter, middle, pose, None, halvings - 1)

    def _settled(self, indenter: Indenter, before: PressState, pose: RealArray, u: RealArray) -> PressState:
        """Return the state at a pose, iterated from displacements ``u``; not settled where the rounds run out."""
        # only points that touch, or may touch in this step, take part
        near = np.flatnonzero((gaps(indenter, pose, self._points_at(u)) < REACH) | before.traction.any(axis=1))
        surface = Surface(self._points.chosen(near), self._kernel.displace_surface, self.grid.shape)
        friction_state = self._grip(before, pose, near)
        mixing = Mixing()
        values = before.traction[near]
        force, total = surface.on_grid(values), np.full(3, np.inf)
        for _ in range(ROUNDS):
            load = -self._strain.forces(u)
            relaxed = u[:, -1] + self._kernel.displace(load)[:, -1]
            contact = surface.settle(
                relaxed, values, force, friction_state, lambda at: gaps_and_normals(indenter, pose, at)
            )
            values, force = contact.tractions, contact.force
            load[:, -1] += force
            error = self._kernel.displace(load)
            last, total = total, force.sum(axis=(1, 2))
            moved, change = float(np.abs(error[:, -1]).max()), np.abs(total - last).max()
            if not np.isfinite(moved):
                return replace(before, pose=pose, is_settled=False)
            enough = self._tolerance * np.abs(total).max() + LEAST_FORCE
            if moved < MOVE_SHARE * self._tolerance and change <= enough:
                break
            u = mixing.next(u, error, load)
        is_settled = moved < UNSETTLED and bool(change <= 10 * enough)
        return self._state(u, contact, near, pose, is_settled)

    def _points_at(self, u: RealArray) -> RealArray:
        """Return the places (n, 3), m, of all touch points at displacements ``u``."""
        return self._points.places + self._points.share @ u[:, -1].reshape(3, -1).T

    def _grip(self, before: PressState, pose: RealArray, near: NDArray[np.intp]) -> FrictionState:
        """Return the friction state of the near points: tractions and places, turned with the indenter."""
        turn = pose[:3, :3] @ before.pose[:3, :3].T
        carried = (before.points[near] - before.pose[:3, 3]) @ turn.T + pose[:3, 3]
        held = before.traction[near] @ turn.T
        fresh = before.gap[near] > TOUCHED
        return FrictionState(
            SPRINGS * self._gel_stiffness, self._gel_stiffness, self.material.friction, held, carried, fresh
        )

    def _state(
        self, u: RealArray, contact: SurfaceContact, near: NDArray[np.intp], pose: RealArray, is_settled: bool
    ) -> PressState:
        """Return the state of displacements ``u`` and of the contact of the near points, with its wrench."""
        points = self._points_at(u)
        points[near] = contact.points
        traction = np.zeros_like(points)
        traction[near] = contact.tractions
        gap = np.full(len(points), np.inf)
        gap[near] = contact.gap
        places = np.stack([*np.meshgrid(self.grid.x, self.grid.y), self._heights]) + u[:, -1]
        torque = np.cross(places, contact.force, axis=0).sum(axis=(1, 2))
        wrench = -np.concatenate([contact.force.sum(axis=(1, 2)), torque])
        return PressState(u, traction, gap, points, pose, wrench, contact.is_slipping, is_settled)


def _between(first: RealArray, second: RealArray) -> RealArray:
    """Return the pose (4, 4) half way between two poses."""
    middle = (first + second) / 2
    middle[:3, :3] = Rotation.from_matrix([first[:3, :3], second[:3, :3]]).mean().as_matrix()
    return middle


def lame_constants(material: Material) -> tuple[float, float]:
    """Return the shear modulus mu and Lamé's lambda, Pa, of a material."""
    e, nu = material.youngs_modulus, material.poisson_ratio
    return e / (2 * (1 + nu)), e * nu / ((1 + nu) * (1 - 2 * nu))
