"""One touch along its path: the moments at which the pad is solved, and forces in between."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from tactiledata.prove.element_world.bodies import RigidBody
from tactiledata.prove.element_world.grid import contact_box, grid_lines, spacing_for
from tactiledata.prove.element_world.pad import Array, BrickPad, Rows
from tactiledata.prove.element_world.steps import State, Stepper
from tactiledata.prove.element_world.surface import Pose, SpringSurface

INTO, ALONG, OUT = 0.13, 0.2, 0.22
"""Longest step, mm: into the gel, along it and out of it."""
FIRST = 0.4
"""Share of a step after which the first one along a new direction is solved."""
LEAST_DEPTH = 1e-3
"""Depth, mm, from which a body touches."""
STILL = 1e-4
"""Move, mm, that changes nothing."""


@dataclass(frozen=True)
class GelPad:
    """A gel under a touch.

    Parameters
    ----------
    outline : (2,), mm
        Sides along x and y.
    thickness : mm
        From the base to the outer surface.
    poisson_ratio, friction : float
        Of the material; forces are over its modulus.
    """

    outline: tuple[float, float]
    thickness: float
    poisson_ratio: float
    friction: float


@dataclass(frozen=True)
class Travel:
    """A rigid body's way over a gel.

    Parameters
    ----------
    body : RigidBody
        What moves.
    rotation : (3, 3)
        Of the body, gel_from_indenter.
    lowest : mm
        Height of the lowest point over the tip; at most 0.
    positions : (n, 3), mm
        x and y of the tip, and depth of the lowest point below the surface at rest, at even moments.
    corners : (k,)
        Rows at which straight moves end.
    """

    body: RigidBody
    rotation: Array
    lowest: float
    positions: Array
    corners: Rows

    def tip(self, row: int) -> Array:
        """Return the place (3,), mm, of the tip at a row."""
        x, y, depth = self.positions[row]
        return np.array([x, y, -depth - self.lowest])

    def pose(self, row: int) -> Pose:
        """Return the pose of the body at a row."""
        return Pose(self.body, self.rotation, self.tip(row))


@dataclass(frozen=True)
class Solved:
    """The contact of one touch, over Young's modulus.

    Parameters
    ----------
    wrench : (n, 6), mm² and mm³
        Of the gel on the body, gel frame, about its origin.
    slipping : (n,) bool
        Whether all that touches slips.
    unsettled : int
        Number of steps that ended without balance.
    steps : int
        Number of moments that were solved.
    """

    wrench: Array
    slipping: NDArray[np.bool_]
    unsettled: int
    steps: int


def solve_touch(gel: GelPad, travel: Travel, finer: float = 1.0) -> Solved:
    """Return the contact of one touch.

    Parameters
    ----------
    gel : GelPad
        The pad and its material.
    travel : Travel
        The way of the body.
    finer : float
        Factor on the fineness of the grid and of the steps.
    """
    count = len(travel.positions)
    wrench, slipping = np.zeros((count, 6)), np.zeros(count, dtype=bool)
    deep = np.flatnonzero(travel.positions[:, 2] > LEAST_DEPTH)
    if not len(deep):
        return Solved(wrench, slipping, 0, 0)
    moments = solved_moments(travel, finer)
    box, narrow = contact_box(travel.body, travel.rotation, np.array([travel.tip(row) for row in moments]))
    spacing = spacing_for(narrow, finer)
    pad = BrickPad(grid_lines(gel.outline, gel.thickness, box, spacing), gel.poisson_ratio)
    stepper = Stepper(pad, SpringSurface(pad, gel.friction, spacing))
    state: State | None = None
    unsettled, steps, found = 0, 0, np.zeros((len(moments), 6))
    slips = np.zeros(len(moments), dtype=bool)
    for place, row in enumerate(moments):
        if travel.positions[row, 2] <= LEAST_DEPTH:
            unsettled, state = unsettled + (state.unsettled if state else 0), None
            continue
        pose = travel.pose(row)
        if state is None:
            # the body comes from where it just touches
            above = Pose(pose.body, pose.rotation, pose.tip + np.array([0.0, 0.0, travel.positions[row, 2]]))
            state = stepper.rest(above)
        if np.linalg.norm(pose.tip - state.held.tip) > STILL:
            state, steps = stepper.move(state, pose), steps + 1
        found[place], slips[place] = state.wrench, state.is_slipping
    unsettled += state.unsettled if state else 0
    return Solved(_between(travel, moments, found), _held(moments, slips, count), unsettled, steps)


def solved_moments(travel: Travel, finer: float = 1.0) -> Rows:
    """Return the rows at which the pad is solved: corners, where touch begins and ends, and enough in between.

    Parameters
    ----------
    travel : Travel
        The way of the body.
    finer : float
        Factor on the number of steps.
    """
    positions = travel.positions
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(positions, axis=0), axis=1))])
    touching = positions[:, 2] > LEAST_DEPTH
    edges = np.flatnonzero(np.diff(touching.astype(int)))
    corners = np.unique(np.concatenate([[0, len(positions) - 1], travel.corners, edges, edges + 1]))
    chosen, before = [corners], np.zeros(3)
    for start, end in pairwise(corners):
        if not touching[start] or not touching[end] or end - start < 2:
            continue
        move = positions[end] - positions[start]
        far = float(np.linalg.norm(move))
        if far < STILL:
            continue
        down = move[2] / far
        step = (INTO if down > 0.1 else OUT if down < -0.1 else ALONG) / finer
        # drift of the body adds to its straight moves
        far = max(far, float(length[end] - length[start]))
        pieces = int(np.ceil(far / step - 1e-6))
        shares = np.arange(1, pieces) / pieces
        if not touching[max(start - 1, 0)]:
            # a touch begins: forces grow from nothing
            shares = (np.arange(1, pieces + 1) / (pieces + 1)) ** 1.5
        elif before @ move < 0.7 * far * float(np.linalg.norm(before)):
            shares = np.append(FIRST / pieces, shares)
        before = move
        marks = length[start] + shares * (length[end] - length[start])
        chosen.append(start + np.searchsorted(length[start : end + 1], marks))
    return np.unique(np.concatenate(chosen))


def _between(travel: Travel, moments: Rows, values: Array) -> Array:
    """Return values (n, 6) at all rows from those (k, 6) at the moments, by splines within each straight move."""
    positions = travel.positions
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(positions, axis=0), axis=1))])
    out = np.zeros((len(positions), values.shape[1]))
    ends = np.unique(np.concatenate([[0, len(positions) - 1], travel.corners]))
    touching = positions[:, 2] > LEAST_DEPTH
    edges = np.flatnonzero(np.diff(touching.astype(int)))
    # forces begin and end at the last row in the air
    ends = np.unique(np.concatenate([ends, edges[touching[edges + 1]], edges[touching[edges]] + 1]))
    for start, end in pairwise(ends):
        mine = np.flatnonzero((moments >= start) & (moments <= end))
        at, first = np.unique(length[moments[mine]], return_index=True)
        rows = np.arange(start, end + 1)
        if len(at) < 3:
            for column in range(values.shape[1]):
                out[rows, column] = np.interp(length[rows], at, values[mine[first], column])
        else:
            out[rows] = PchipInterpolator(at, values[mine[first]], axis=0)(length[rows])
    out[~touching] = 0.0
    return out


def _held(moments: Rows, slips: NDArray[np.bool_], count: int) -> NDArray[np.bool_]:
    """Return whether all slips (n,) at all rows: as at the next moment that was solved."""
    return slips[np.clip(np.searchsorted(moments, np.arange(count)), 0, len(moments) - 1)]
