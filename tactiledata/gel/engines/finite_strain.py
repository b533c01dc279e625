"""Many touches at finite strain in lockstep: one factor and one sweep over the cells serve all of them."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from threadpoolctl import ThreadpoolController

from tactiledata.arrays import Array, Indices
from tactiledata.gel.contact.history import GelHistory
from tactiledata.gel.contact.trajectory_solve import TrajectorySolve
from tactiledata.gel.elasticity.compliance import FactorisedPad
from tactiledata.gel.elasticity.internal_forces import NEO_HOOKEAN, ElasticPad, internal_forces
from tactiledata.gel.elasticity.mixing import SecantMixer
from tactiledata.gel.elasticity.stiffening import Stiffening
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.surface import ContactSurface

TOLERANCE = 2e-6
"""m: a step is solved when no node moves further in an iteration."""
FORCE_TOLERANCE = 1e-2
"""And no patch force changes by more than this share of the largest; their sum changes far less."""
PATIENCE = 20
"""Iterations after which a step is taken ``LENIENCE`` times off the tolerances: at sharp rims a few patches keep
trading force among themselves. The frame's residual tells."""
LENIENCE = 4.0
MOST_ITERATIONS = 70
SWEEPS = 8
"""Of the contact solver in each iteration: the outer iterations do the rest."""
FARTHEST = 5e-3
"""m: an iterate that moves a node further is lost."""
BELOW_SURFACE = 3
"""Every so manieth node below the surface measures how far an iterate is from the solution."""


class LoadStepSolve:
    """A journey with its iterate: the whole pad's displacement (v, 3), m, and the patch forces (m, 3), m^2."""

    def __init__(self, journey: TrajectorySolve, tolerance: float, measured: Indices) -> None:
        self.journey = journey
        self._tolerance = tolerance
        state = journey.walk.state
        self.displacement = state.displacement
        self.forces = state.forces
        self.is_under_way = True
        self._iterations = 0
        self._mixer = SecantMixer(state.displacement.size + state.forces.size, measured)
        self._stride: tuple[Array, Array] | None = None

    def start_step(self) -> None:
        """Begin the next load step where the last two lead, or end the journey."""
        self._iterations = 0
        self._mixer.start_step()
        self.is_under_way = self.journey.next_step()
        state = self.journey.walk.state
        if not state.is_touching:
            self._forget()
        self.displacement, self.forces = state.displacement, state.forces
        if self._stride is not None:
            self.displacement = self.displacement + self._stride[0]
            self.forces = self.forces + self._stride[1]

    def judge(self, displacement: Array, forces: Array, gaps: Array, residual: float) -> None:
        """Take what an iteration led to: the step is solved, or lost, or goes on from a mixed iterate."""
        self._iterations += 1
        self.journey.count(1)
        change = float(np.abs(displacement - self.displacement).max()) / self._tolerance
        force_change = float(np.abs(forces - self.forces).max()) / (
            FORCE_TOLERANCE * max(float(np.abs(forces).max()), 1e-30) * self._tolerance / TOLERANCE
        )
        if max(change, force_change) < (LENIENCE if self._iterations > PATIENCE else 1.0):
            self._accept_step(displacement, forces, gaps, residual)
        elif self._iterations >= MOST_ITERATIONS or not np.abs(displacement).max() < FARTHEST:
            self._forget()
            self.journey.step_failed()
            self.start_step()
        else:
            self._mix(displacement, forces)

    def _accept_step(self, displacement: Array, forces: Array, gaps: Array, residual: float) -> None:
        before = self.journey.walk.state
        self._stride = (displacement - before.displacement, forces - before.forces)
        self.journey.walk.accept_step(displacement, forces, gaps)
        frame = self.journey.step_done(residual)
        if frame is not None:
            self.journey.recorder.put_displacement(frame, displacement)
        self.start_step()

    def _mix(self, displacement: Array, forces: Array) -> None:
        size = displacement.size
        point = np.concatenate([self.displacement.ravel(), self.forces.ravel()])
        reached = np.concatenate([displacement.ravel(), forces.ravel()])
        mixed = self._mixer.mix(point, reached)
        self.displacement = mixed[:size].reshape(displacement.shape)
        self.forces = mixed[size:].reshape(forces.shape)

    def _forget(self) -> None:
        self._mixer.forget()
        self._stride = None


class FiniteStrainSolver:
    """Modified Newton iterations with the stiffness at rest, accelerated, the contact solved within each.

    Parameters
    ----------
    pad, elastic, surface : of one mesh
    tolerance : m
        A step is solved when no node moves further in an iteration.
    stiffening : Stiffening
    """

    def __init__(
        self,
        pad: FactorisedPad,
        elastic: ElasticPad,
        surface: ContactSurface,
        tolerance: float = TOLERANCE,
        stiffening: Stiffening = NEO_HOOKEAN,
    ) -> None:
        self._pad, self._elastic, self._surface = pad, elastic, surface
        self._tolerance = tolerance
        self._stiffening = stiffening
        self._measured = _measured(pad.mesh, surface)
        self._libraries = ThreadpoolController()

    def run(self, journeys: Iterator[TrajectorySolve], width: int) -> Iterator[tuple[int, GelHistory]]:
        """Solve journeys, ``width`` at a time; a new one sets out when another has arrived."""
        active: list[LoadStepSolve] = []
        with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as threads:
            while True:
                while len(active) < width and (journey := next(journeys, None)) is not None:
                    active.append(LoadStepSolve(journey, self._tolerance, self._measured))
                    active[-1].start_step()
                if not active:
                    return
                for traveller in active:
                    if not traveller.is_under_way:
                        yield traveller.journey.number, traveller.journey.recorder.history()
                active = [traveller for traveller in active if traveller.is_under_way]
                if active:
                    # threads share the travellers; products that start threads of their own only get in the way
                    with self._libraries.limit(limits=1, user_api="blas"):
                        self._iterate(active, threads)

    def _iterate(self, active: list[LoadStepSolve], threads: ThreadPoolExecutor) -> None:
        """One iteration of every traveller's load step."""
        displacement = np.stack([traveller.displacement for traveller in active])
        unbalanced = internal_forces(self._elastic, displacement, self._pad.poisson_ratio, threads, self._stiffening)

        def press(row: int) -> tuple[Array, Array]:
            forces, gaps = active[row].journey.walk.press(
                displacement[row], active[row].forces, SWEEPS, FORCE_TOLERANCE / 10
            )
            unbalanced[row, self._surface.nodes] -= self._surface.averaging.T @ forces
            return forces, gaps

        pressed = list(threads.map(press, range(len(active))))
        unbalanced[:, self._pad.mesh.base] = 0.0
        reached = displacement - self._pad.solve_roughly(unbalanced, threads)

        def judge(row: int) -> None:
            forces, gaps = pressed[row]
            largest = float(np.abs(forces).max())
            residual = float(np.abs(unbalanced[row]).max()) / largest if largest > 0 else 0.0
            active[row].judge(reached[row], forces, gaps, residual)

        list(threads.map(judge, range(len(active))))


def _measured(mesh: PadMesh, surface: ContactSurface) -> Indices:
    """Which unknowns (k,) of a flattened displacement (v, 3) tell how far an iterate is off."""
    nodes = np.union1d(surface.nodes, np.arange(0, len(mesh.vertices), BELOW_SURFACE))
    return (3 * nodes[:, None] + np.arange(3)).ravel()
