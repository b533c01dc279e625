"""Touches in the small-strain limit: contact on the condensed surface alone, the volume afterwards for all frames."""

from __future__ import annotations

import itertools
import os
from collections import deque
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from tactiledata.arrays import Array
from tactiledata.gel.contact.history import GelHistory
from tactiledata.gel.contact.trajectory_solve import TrajectorySolve
from tactiledata.gel.elasticity.compliance import BATCH, FactorisedPad
from tactiledata.gel.mesh.surface import ContactSurface

FORCE_TOLERANCE = 1e-4
"""A step is solved when no patch force changes by more than this share of the largest."""
MOST_ITERATIONS = 60
UNDAMPED = 10
"""Iterations after which only half of each change is made."""
PATIENCE = 20
LENIENCE = 300.0
"""After so many iterations, how far off the tolerance a step is taken: at narrow pins a few patches keep trading a
hundredth of the largest force; the frame's residual tells."""
SWEEPS = 30


class LinearSolver:
    """Contact iterations with the surface's response; gaps and normals are taken where the surface has moved to.

    Parameters
    ----------
    pad, surface : of one mesh
    response : (s, 3, m, 3)
        See ``surface_response``.
    """

    def __init__(self, pad: FactorisedPad, surface: ContactSurface, response: NDArray[np.float32]) -> None:
        self._pad, self._surface = pad, surface
        # one row for each patch and direction: a step reads those of the pressed patches only
        self._by_patch = np.ascontiguousarray(response.transpose(2, 3, 0, 1)).reshape(*response.shape[2:], -1)

    def run(self, journeys: Iterator[TrajectorySolve]) -> Iterator[tuple[int, GelHistory]]:
        """Solve journeys, one on each thread."""
        count = len(os.sched_getaffinity(0))
        with ThreadPoolExecutor(count) as threads, ThreadpoolController().limit(limits=1, user_api="blas"):
            under_way = deque(threads.submit(self._play, journey) for journey in itertools.islice(journeys, 2 * count))
            while under_way:
                yield under_way.popleft().result()
                under_way.extend(threads.submit(self._play, journey) for journey in itertools.islice(journeys, 1))

    def _play(self, journey: TrajectorySolve) -> tuple[int, GelHistory]:
        kept: dict[int, Array] = {}
        while journey.next_step():
            frame = self._solve_step(journey)
            if frame is not None:
                kept[frame] = journey.walk.state.forces
        if journey.recorder.keeps_displacement:
            self._fill(journey, kept)
        return journey.number, journey.recorder.history()

    def _solve_step(self, journey: TrajectorySolve) -> int | None:
        walk = journey.walk
        forces, displacement = walk.state.forces, walk.state.displacement
        for iteration in range(MOST_ITERATIONS):
            pressed, gaps = walk.press(displacement, forces, SWEEPS, FORCE_TOLERANCE / 10)
            journey.count(1)
            change = float(np.abs(pressed - forces).max()) / max(float(np.abs(pressed).max()), 1e-30)
            # contact at edges can go to and fro between two answers; the middle is nearer
            share = 1.0 if iteration < UNDAMPED else 0.5
            forces = forces + share * (pressed - forces)
            displacement = self._surface_displacement(forces)
            if change <= FORCE_TOLERANCE * (1.0 if iteration < PATIENCE else LENIENCE):
                walk.accept_step(displacement, forces, gaps)
                return journey.step_done(change)
        journey.step_failed()
        return None

    def _surface_displacement(self, forces: Array) -> Array:
        pressed = np.flatnonzero(forces.any(axis=1))
        columns = self._by_patch[pressed].reshape(3 * len(pressed), self._by_patch.shape[-1])
        displacement = forces[pressed].astype(np.float32).ravel() @ columns
        return displacement.astype(float).reshape(-1, 3)

    def _fill(self, journey: TrajectorySolve, kept: dict[int, Array]) -> None:
        """The volume's displacement of all frames that were solved."""
        frames = list(kept)
        for start in range(0, len(frames), BATCH):
            part = frames[start : start + BATCH]
            loads = np.zeros((len(part), len(self._pad.mesh.vertices), 3))
            for row, frame in enumerate(part):
                loads[row, self._surface.nodes] = self._surface.averaging.T @ kept[frame]
            for frame, displacement in zip(part, self._pad.solve_refined(loads), strict=True):
                journey.recorder.put_displacement(frame, displacement)
