"""One touch by the layer solver: its path cut into small steps, and forces interpolated between them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from tactiledata.arrays import RealArray
from tactiledata.rig.contact.contact import DEEPEST, TouchSetup, contact_times, deviation_at
from tactiledata.rig.contact.layer_picture import drawn_surface
from tactiledata.rig.layer.grid import LayerGrid
from tactiledata.rig.layer.press import extrapolated
from tactiledata.rig.layer.solver import Layer, PressState
from tactiledata.rig.motion.motion import Path

STEP, STEP_OUT = 1e-4, 2e-4
"""Longest step of the solver, m: into the gel or along it, and out of the gel."""


@dataclass(frozen=True)
class LayerContact:
    """A `RigContact` by the layer solver.

    Parameters
    ----------
    setup : TouchSetup
        The touch as it really is.
    grid : LayerGrid
        Grid of the solver.
    path : Path
        The commanded path.
    wrench : (n, 6), N, N m
        See `RigContact.wrench`.
    slipping : (n,) bool
        See `RigContact.slipping`.
    marks : (k,), m
        Length of the path up to each step of the solver.
    surfaces : (k, 3, rows, columns), m, float32
        Displacements of the gel's surface at those steps.
    unsettled : int
        Number of the solver's steps that did not converge.
    deviation : (n, 3), m, optional
        See `RigContact.deviation`.
    """

    setup: TouchSetup
    grid: LayerGrid
    path: Path
    wrench: RealArray
    slipping: NDArray[np.bool_]
    marks: RealArray
    surfaces: NDArray[np.float32]
    unsettled: int
    deviation: RealArray | None = None

    def surface(self, seconds: float) -> NDArray[np.float32]:
        """Return the height (n_y, n_x), m, of the gel's surface at seconds from the start."""
        setup, moment = self.setup, np.array([seconds])
        x, y, depth = self.path.at(moment)[0] + setup.offset + deviation_at(self.deviation, moment)[0]
        place = float(np.interp(self.path.travelled(moment)[0], self.marks, np.arange(len(self.marks))))
        index = min(int(place), len(self.marks) - 2)
        first, second = self.surfaces[index], self.surfaces[index + 1]
        displacement = first + np.float32(place - index) * (second - first)
        # the picture's points lie finer than the solver's, under the indenter where it really is
        moved = (float(x - setup.footprint.position[0]), float(y - setup.footprint.position[1]))
        fine = setup.footprint.grid
        fall = setup.cap.fall_from(setup.touch.position, *np.meshgrid(fine.x, fine.y)).astype(np.float32)
        return drawn_surface(displacement, self.grid, setup.footprint, moved, float(depth), fall)


def touch_layer(
    setup: TouchSetup, layer: Layer, path: Path | None = None, deviation: RealArray | None = None
) -> LayerContact:
    """Play a touch by the layer solver and return its contact.

    Parameters
    ----------
    setup : TouchSetup
        The touch as it really is.
    layer : Layer
        The pad.
    path : Path, optional
        The path where it is planned already; else presses stop at the limit of force, found by the solver.
    deviation : (n, 3), m, optional
        See `RigContact.deviation`; at the solver's steps it is interpolated over the path's length.
    """
    place = setup.touch.position
    if setup.cap.curvature:
        layer = layer.lowered(lambda x, y: setup.cap.fall_from(place, x, y))
    path_solve = _PathSolve(setup, layer)
    path = path or setup.plan(lambda _: _deepest(setup, path_solve))
    marks, positions = solver_steps(path, setup.offset)
    at = path.travelled(contact_times(path))
    if deviation is not None:
        positions = positions + np.stack([np.interp(marks, at, column) for column in deviation.T], axis=1)
    states = path_solve.along(positions)
    wrenches = np.array([state.wrench for state in states])
    # the solver takes the surface at the touch as z = 0, which a dome's is not
    wrenches[:, 3:] -= np.cross([0.0, 0.0, float(setup.cap.fall(*place))], wrenches[:, :3])
    slips = np.array([state.is_slipping for state in states])
    return LayerContact(
        setup=setup,
        grid=layer.grid,
        path=path,
        wrench=_between_steps(marks, wrenches, at),
        slipping=slips[np.clip(np.searchsorted(marks, at), 0, len(marks) - 1)],
        marks=marks,
        surfaces=np.array([state.u[:, -1] for state in states], dtype=np.float32),
        unsettled=sum(not state.is_settled for state in states),
        deviation=deviation,
    )


def solver_steps(path: Path, offset: RealArray) -> tuple[RealArray, RealArray]:
    """Return the solver's stops on a path: metres travelled (k,), strictly rising, and real positions (k, 3), m.

    The stops are the ends of moves, first and last touch, and between them as many as keep steps below ``STEP``.
    """
    positions = path.positions + offset
    marks, stops, travelled = [0.0], [positions[0]], 0.0
    for start, end in pairwise(positions):
        length = float(np.linalg.norm(end - start))
        if length < 1e-12:
            continue
        # the part of the move inside the gel
        first, last = 0.0, 1.0
        if start[2] * end[2] < 0:
            crossing = float(start[2] / (start[2] - end[2]))
            first, last = (crossing, 1.0) if start[2] < 0 else (0.0, crossing)
        if max(start[2], end[2]) <= 0:
            shares = np.array([1.0])
        else:
            longest = STEP_OUT if end[2] < start[2] else STEP
            count = max(int(np.ceil(length * (last - first) / longest - 1e-6)), 1)
            shares = np.unique(np.append(np.linspace(first, last, count + 1), 1.0))
        for share in shares[shares > 0]:
            marks.append(travelled + share * length)
            stops.append(start + share * (end - start))
        travelled += length
    return np.array(marks), np.array(stops)


class _PathSolve:
    """The solver's states along positions; states are reused as far as the positions are the same as before."""

    def __init__(self, setup: TouchSetup, layer: Layer) -> None:
        self._setup, self._layer = setup, layer
        self._trail: list[tuple[RealArray, PressState]] = []

    def along(self, positions: RealArray) -> list[PressState]:
        """Return the states at positions (k, 3), m: x, y of the tip, depth."""
        return [self.at(positions, index) for index in range(len(positions))]

    def at(self, positions: RealArray, index: int) -> PressState:
        """Return the state at the position ``index``; the positions before it must have been solved."""
        if index < len(self._trail) and np.array_equal(self._trail[index][0], positions[index]):
            return self._trail[index][1]
        del self._trail[index:]
        pose, indenter = self._pose(positions[index]), self._setup.indenter
        if index == 0:
            state = self._layer.at_rest(indenter, pose)
        else:
            before = self._trail[index - 1][1]
            guess = extrapolated(self._trail[index - 2][1], before, pose) if index > 1 else None
            state = self._layer.step(indenter, before, pose, guess)
        self._trail.append((positions[index], state))
        return state

    def _pose(self, position: RealArray) -> RealArray:
        """Return gel_from_indenter (4, 4) at a position (3,), m: x, y of the tip, depth of the lowest point."""
        pose = np.eye(4)
        pose[:3, :3] = self._setup.rotation
        pose[:3, 3] = position[0], position[1], -position[2] - self._setup.footprint.lowest
        return pose


def _deepest(setup: TouchSetup, path_solve: _PathSolve) -> float:
    """Return the commanded depth, m, at which the first press reaches the limit of force; else the deepest allowed."""
    allowed = DEEPEST * setup.thickness
    _, positions = solver_steps(setup.plan(lambda _: allowed), setup.offset)
    force, depth = 0.0, float(positions[0][2])
    for index, position in enumerate(positions):
        if not np.array_equal(position[:2], positions[0][:2]) or position[2] < depth:
            break
        last, force = force, float(path_solve.at(positions, index).wrench[2])
        if force > setup.normal_limit:
            share = (setup.normal_limit - last) / (force - last)
            return depth + share * (float(position[2]) - depth) - float(setup.offset[2])
        depth = float(position[2])
    return allowed


def _between_steps(marks: RealArray, values: RealArray, at: RealArray) -> RealArray:
    """Return values (n, 6) at metres ``at`` (n,) of the path: smooth within each contact, zero outside.

    ``values`` (k, 6) are those at the solver's steps, ``marks`` (k,) the path's length up to them, m.
    """
    out = np.zeros((len(at), values.shape[1]))
    touching = values.any(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], touching, [False]]).astype(int)))
    for first, end in edges.reshape(-1, 2):
        # the free steps before and after belong to it: force begins and ends there
        part = slice(max(first - 1, 0), min(end + 1, len(marks)))
        inside = (at >= marks[part][0]) & (at <= marks[part][-1])
        out[inside] = PchipInterpolator(marks[part], values[part], axis=0)(at[inside])
    return out
