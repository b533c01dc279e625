"""Solver in the small-strain limit: contact iterations on the condensed surface, the volume afterwards."""

from __future__ import annotations

import itertools
import os
from collections import deque
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numba import njit
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from tactiledata.arrays import Array, Indices
from tactiledata.gel.contact.history import GelHistory
from tactiledata.gel.contact.trajectory_solve import TrajectorySolve
from tactiledata.gel.elasticity.compliance import BATCH, FactorisedPad
from tactiledata.gel.mesh.surface import ContactSurface

FORCE_TOLERANCE = 1e-3
"""Largest change of a patch force in the iteration that completes a load step, as a share of the largest force."""
MOST_ITERATIONS = 60
"""Iterations after which a load step has failed."""
UNDAMPED = 10
"""Iterations after which only half of each change is made."""
PATIENCE = 20
"""Iterations after which the tolerance is ``LENIENCE`` times as large."""
LENIENCE = 30.0
"""Factor on the tolerance after ``PATIENCE`` iterations.

At narrow pins a few patches keep exchanging a hundredth of the largest force. The frame's residual shows the error."""
SWEEPS = 30
"""Sweeps of the contact solver in each iteration."""


class LinearSolver:
    """Contact iterations with the linear response of the surface; gaps and normals are those of the moved surface.

    Parameters
    ----------
    pad : FactorisedPad
        Stiffness of a mesh.
    surface : ContactSurface
        Patches of the same mesh.
    response : (s, 3, m, 3) 1/m
        Displacements of surface nodes under unit patch forces: see ``surface_response``.
    """

    def __init__(self, pad: FactorisedPad, surface: ContactSurface, response: NDArray[np.float32]) -> None:
        self._pad, self._surface = pad, surface
        # by patch and node, so that a step reads what it needs in one piece: the pressed patches, the nodes in reach
        self._by_patch = np.ascontiguousarray(response.transpose(2, 0, 3, 1))
        self._all_nodes = np.arange(len(surface.nodes))

    def run(self, trajectories: Iterator[TrajectorySolve]) -> Iterator[tuple[int, GelHistory]]:
        """Solve trajectories, one on each thread, and yield the number and the answer of each, in order."""
        count = len(os.sched_getaffinity(0))
        with ThreadPoolExecutor(count) as threads, ThreadpoolController().limit(limits=1, user_api="blas"):
            running = deque(
                threads.submit(self._play, trajectory) for trajectory in itertools.islice(trajectories, 2 * count)
            )
            while running:
                yield running.popleft().result()
                running.extend(
                    threads.submit(self._play, trajectory) for trajectory in itertools.islice(trajectories, 1)
                )

    def _play(self, trajectory: TrajectorySolve) -> tuple[int, GelHistory]:
        """Solve all frames of one trajectory."""
        frame_forces: dict[int, Array] = {}
        while trajectory.next_step():
            frame = self._solve_step(trajectory)
            if frame is not None:
                frame_forces[frame] = trajectory.path.state.forces
        if trajectory.recorder.keeps_displacement:
            self._fill(trajectory, frame_forces)
        return trajectory.number, trajectory.recorder.history()

    def _solve_step(self, trajectory: TrajectorySolve) -> int | None:
        """Solve the present load step, or report that it failed; return the frame that it completes, or ``None``."""
        path = trajectory.path
        forces, displacement = path.state.forces, path.state.displacement.copy()
        in_reach = path.nodes_in_reach()
        for iteration in range(MOST_ITERATIONS):
            pressed, gaps = path.press(displacement, forces, SWEEPS, FORCE_TOLERANCE / 10)
            trajectory.count(1)
            change = float(np.abs(pressed - forces).max()) / max(float(np.abs(pressed).max()), 1e-30)
            # contact at edges can alternate between two solutions; their mean is nearer
            share = 1.0 if iteration < UNDAMPED else 0.5
            forces = forces + share * (pressed - forces)
            is_last = change <= FORCE_TOLERANCE * (1.0 if iteration < PATIENCE else LENIENCE)
            move_nodes(self._by_patch, forces, self._all_nodes if is_last else in_reach, displacement)
            if is_last:
                path.accept_step(displacement, forces, gaps)
                return trajectory.step_done(change)
        trajectory.step_failed()
        return None

    def _fill(self, trajectory: TrajectorySolve, frame_forces: dict[int, Array]) -> None:
        """Record the displacements of all nodes in the solved frames, from patch forces (m, 3) of each frame."""
        frames = list(frame_forces)
        for start in range(0, len(frames), BATCH):
            part = frames[start : start + BATCH]
            loads = np.zeros((len(part), len(self._pad.mesh.vertices), 3))
            for row, frame in enumerate(part):
                loads[row, self._surface.nodes] = self._surface.averaging.T @ frame_forces[frame]
            for frame, displacement in zip(part, self._pad.solve_refined(loads), strict=True):
                trajectory.recorder.put_displacement(frame, displacement)


@njit(nogil=True, cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"})
def move_nodes(by_patch: NDArray[np.float32], forces: Array, nodes: Indices, displacement: Array) -> None:
    """Write the displacements of some surface nodes under patch forces to their rows of ``displacement``.

    Parameters
    ----------
    by_patch : (m, s, 3, 3) 1/m
        Displacement (last axis) of each node by a unit force on each patch along each axis (third).
    forces : (m, 3) m^2
        Patch forces over Young's modulus.
    nodes : (k,)
        Nodes whose rows are written.
    displacement : (s, 3) m
        Changed in place; rows of other nodes stay as they are.
    """
    for node in nodes:
        displacement[node] = 0.0
    for patch in range(len(forces)):
        x, y, z = forces[patch, 0], forces[patch, 1], forces[patch, 2]
        if x == 0.0 and y == 0.0 and z == 0.0:
            continue
        responses = by_patch[patch]
        for node in nodes:
            response = responses[node]
            for axis in range(3):
                displacement[node, axis] += x * response[0, axis] + y * response[1, axis] + z * response[2, axis]
