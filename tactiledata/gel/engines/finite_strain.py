"""Solver at finite strain for many trajectories in lockstep, which share one factor and each sweep over the cells."""

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
from tactiledata.gel.elasticity.deformed import TangentFactory
from tactiledata.gel.elasticity.internal_forces import NEO_HOOKEAN, ElasticPad, internal_forces
from tactiledata.gel.elasticity.mixing import SecantMixer
from tactiledata.gel.elasticity.stiffening import Stiffening
from tactiledata.gel.engines.tangent_step import FARTHEST, Body, TangentStep
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.surface import ContactSurface

TOLERANCE = 2e-6
"""Largest change of a node's position, m, in the iteration that completes a load step."""
FORCE_TOLERANCE = 1e-2
"""Largest change of a patch force in that iteration, as a share of the largest force; the sum changes far less."""
PATIENCE = 20
"""Iterations after which the tolerances are ``LENIENCE`` times as large.

At sharp rims a few patches keep exchanging force without converging. The frame's residual shows the remaining error."""
LENIENCE = 4.0
"""Factor on the tolerances after ``PATIENCE`` iterations."""
MOST_ITERATIONS = 70
"""Iterations after which a load step has failed."""
SWEEPS = 8
"""Sweeps of the contact solver in each iteration; the outer iterations do the rest."""
BELOW_SURFACE = 3
"""Stride of the interior nodes that enter the residual norm."""


class LoadStepSolve:
    """One trajectory with the iterate of its present load step.

    The iterate is the displacement (v, 3), m, of all nodes, and the patch forces (m, 3), m^2.

    Parameters
    ----------
    trajectory : TrajectorySolve
        Order of load steps.
    tolerance : m
        Largest change of a node's position in the iteration that completes a step.
    measured : (k,) int
        Places of the unknowns that enter the residual norm.
    body : Body
        Parts of the engine that a Newton iteration needs.
    """

    def __init__(self, trajectory: TrajectorySolve, tolerance: float, measured: Indices, body: Body) -> None:
        self.trajectory = trajectory
        self._tangent_step = TangentStep(body, tolerance)
        self.is_hard = False
        self._tolerance = tolerance
        state = trajectory.path.state
        self.displacement = state.displacement
        self.forces = state.forces
        self.is_active = True
        self._iterations = 0
        self._mixer = SecantMixer(state.displacement.size + state.forces.size, measured)
        self._stride: tuple[Array, Array] | None = None

    def start_step(self) -> None:
        """Start the next load step, extrapolated from the last two, or end the trajectory."""
        self._iterations = 0
        self._mixer.start_step()
        self.is_active = self.trajectory.next_step()
        state = self.trajectory.path.state
        if not state.is_touching:
            self._forget()
            self._tangent_step.forget()
            self.is_hard = False
        if self.is_hard and self.is_active:
            self._tangent_step.start(self.trajectory.path)
        self.displacement, self.forces = state.displacement, state.forces
        if self._stride is not None:
            self.displacement = self.displacement + self._stride[0]
            self.forces = self.forces + self._stride[1]

    def take_iteration(self, displacement: Array, forces: Array, gaps: Array, residual: float) -> None:
        """Take the result of an iteration: accept the step, give it up, or continue from an accelerated iterate.

        Parameters
        ----------
        displacement : (v, 3) m
            Result of the iteration.
        forces : (m, 3) m^2
            Patch forces over Young's modulus.
        gaps : (m,) m
            Distance of each patch from the indenter.
        residual : float
            Largest unbalanced nodal force over the largest contact force.
        """
        self._iterations += 1
        self.trajectory.count(1)
        change = float(np.abs(displacement - self.displacement).max()) / self._tolerance
        force_change = float(np.abs(forces - self.forces).max()) / (
            FORCE_TOLERANCE * max(float(np.abs(forces).max()), 1e-30) * self._tolerance / TOLERANCE
        )
        # both changes are in units of their tolerance
        if max(change, force_change) < (LENIENCE if self._iterations > PATIENCE else 1.0):
            self._accept_step(displacement, forces, gaps, residual)
        elif self._iterations >= MOST_ITERATIONS or not np.abs(displacement).max() < FARTHEST:
            # the same step once more, with the tangent at the present state
            self._forget()
            self.is_hard = True
            self._tangent_step.start(self.trajectory.path)
        else:
            self._mix(displacement, forces)

    def iterate_with_tangent(self) -> None:
        """Make a Newton iteration with the tangent at the present state: accept the step, divide it, or continue.

        After a solved step the usual iterations are tried again; the tangent is kept for where they fail.
        """
        self.trajectory.count(1)
        solved = self._tangent_step.iterate(self.trajectory.path)
        if solved is not None:
            self.is_hard = False
            self._accept_step(solved.displacement, solved.forces, solved.gaps, solved.residual)
        elif self._tangent_step.has_failed:
            self.trajectory.step_failed()
            self.start_step()

    def _accept_step(self, displacement: Array, forces: Array, gaps: Array, residual: float) -> None:
        """Take an equilibrium, record the frame that it completes, and start the next step."""
        before = self.trajectory.path.state
        self._stride = (displacement - before.displacement, forces - before.forces)
        self.trajectory.path.accept_step(displacement, forces, gaps)
        frame = self.trajectory.step_done(residual)
        if frame is not None:
            self.trajectory.recorder.put_displacement(frame, displacement)
        self.start_step()

    def _mix(self, displacement: Array, forces: Array) -> None:
        """Set the next iterate by Anderson acceleration."""
        size = displacement.size
        point = np.concatenate([self.displacement.ravel(), self.forces.ravel()])
        image = np.concatenate([displacement.ravel(), forces.ravel()])
        mixed = self._mixer.mix(point, image)
        self.displacement = mixed[:size].reshape(displacement.shape)
        self.forces = mixed[size:].reshape(forces.shape)

    def _forget(self) -> None:
        """Drop what the acceleration and the extrapolation remember of earlier steps."""
        self._mixer.forget()
        self._stride = None


class FiniteStrainSolver:
    """Accelerated modified Newton iterations with the stiffness at rest; contact is solved within each iteration.

    A load step for which they find no equilibrium is solved by ``TangentStep``. A tangent costs as much as a hundred of
    these iterations, so that they are tried again at the next load step.

    Parameters
    ----------
    pad : FactorisedPad
        Stiffness at rest of a mesh.
    elastic : ElasticPad
        Nodal forces of the same mesh.
    surface : ContactSurface
        Patches of the same mesh.
    tolerance : m
        A load step is solved when no node moves further than this in an iteration.
    stiffening : Stiffening
        Yeoh's terms of the law.
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
        tangents = TangentFactory(pad, elastic, surface, stiffening)
        self._body = Body(pad.mesh, elastic, surface, pad.poisson_ratio, stiffening, tangents)
        self._libraries = ThreadpoolController()

    def run(self, trajectories: Iterator[TrajectorySolve], width: int) -> Iterator[tuple[int, GelHistory]]:
        """Solve trajectories, ``width`` at a time, and yield the number and the answer of each when it is done."""
        active: list[LoadStepSolve] = []
        with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as threads:
            while True:
                while len(active) < width and (trajectory := next(trajectories, None)) is not None:
                    active.append(LoadStepSolve(trajectory, self._tolerance, self._measured, self._body))
                    active[-1].start_step()
                if not active:
                    return
                for load_step in active:
                    if not load_step.is_active:
                        yield load_step.trajectory.number, load_step.trajectory.recorder.history()
                active = [load_step for load_step in active if load_step.is_active]
                if active:
                    # trajectories are divided among threads; BLAS products must not start threads beside them
                    with self._libraries.limit(limits=1, user_api="blas"):
                        hard = [load_step for load_step in active if load_step.is_hard]
                        list(threads.map(LoadStepSolve.iterate_with_tangent, hard))
                        easy = [load_step for load_step in active if load_step.is_active and not load_step.is_hard]
                        if easy:
                            self._iterate(easy, threads)

    def _iterate(self, active: list[LoadStepSolve], threads: ThreadPoolExecutor) -> None:
        """Make one iteration of the load step of every active trajectory."""
        displacement = np.stack([load_step.displacement for load_step in active])
        unbalanced = internal_forces(self._elastic, displacement, self._pad.poisson_ratio, threads, self._stiffening)

        # contact forces at the present displacements, taken off the unbalanced forces
        def press(row: int) -> tuple[Array, Array]:
            """Patch forces (m, 3), m^2, and gaps (m,), m, of one trajectory."""
            forces, gaps = active[row].trajectory.path.press(
                displacement[row], active[row].forces, SWEEPS, FORCE_TOLERANCE / 10
            )
            unbalanced[row, self._surface.nodes] -= self._surface.averaging.T @ forces
            return forces, gaps

        pressed = list(threads.map(press, range(len(active))))
        # modified Newton step with the stiffness at rest
        unbalanced[:, self._pad.mesh.base] = 0.0
        image = displacement - self._pad.solve_roughly(unbalanced, threads)

        def finish(row: int) -> None:
            """Give one trajectory the result of the iteration."""
            forces, gaps = pressed[row]
            largest = float(np.abs(forces).max())
            residual = float(np.abs(unbalanced[row]).max()) / largest if largest > 0 else 0.0
            active[row].take_iteration(image[row], forces, gaps, residual)

        list(threads.map(finish, range(len(active))))


def _measured(mesh: PadMesh, surface: ContactSurface) -> Indices:
    """Places (k,) of a flattened displacement (v, 3) that enter the residual norm: the surface and some inner nodes."""
    nodes = np.union1d(surface.nodes, np.arange(0, len(mesh.vertices), BELOW_SURFACE))
    return (3 * nodes[:, None] + np.arange(3)).ravel()
