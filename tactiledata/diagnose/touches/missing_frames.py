"""Frames that a play has not solved, interpolated from the frames that it has and from the middle play.

A diagnosis plays every touch at many parameters. A frame that one of these plays lacks is estimated, so that it is not
lost to all of them. The estimate follows the middle play at that frame: its load, shear and contact area are multiplied
by factors, and its centre of pressure is moved. Factors and motion are those between the two plays at other loads of
the same touch, interpolated over the load.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tactiledata.arrays import Array, Mask
from tactiledata.calibrate.experiment import KNOWN
from tactiledata.calibrate.plays.kept_plays import Play
from tactiledata.diagnose.touches.played_columns import pressed, wrench_at_height
from tactiledata.effects.touch.state import wrench_at
from tactiledata.gel.contact.history import FrameStatus

LEAST_SHEAR = 0.02
"""Shear determines a factor of its own if it is at least this share of the load."""
NEIGHBOURS = 5
"""Number of frames of other touches, next in load, whose median factors are used where a touch has no solved frame."""


class Loads(NamedTuple):
    """Contact of a play as load, shear, centre of pressure, spin and area; forces are over Young's modulus, in m^2.

    Parameters
    ----------
    load : (n,)
        Normal force; 0 without contact.
    shear : (n, 2)
        Force along x and y.
    centre : (n, 2) m
        Centre of pressure at the height of the tip; 0 without contact.
    spin : (n,) m^3
        Torque about the normal through the centre.
    area : (n,) m^2
        Area of the contact.
    """

    load: Array
    shear: Array
    centre: Array
    spin: Array
    area: Array

    @staticmethod
    def of(play: Play, heights: Array) -> Loads:
        """Return the loads of a play; those of frames that are not solved are 0.

        Parameters
        ----------
        play : Play
            Wrench, status and area of n frames.
        heights : (n,) m
            Height of the tip in the gel frame.
        """
        columns = np.column_stack([np.nan_to_num(play.wrench), np.nan_to_num(play.area)])
        tips = np.column_stack([np.zeros((len(heights), 2)), heights])
        # a depth of 1 m everywhere: whether there is contact is decided by the load alone
        wrench, centre, area, load = pressed(columns, np.ones(len(heights)), tips, tips[:, :2])
        spin = wrench[:, 5] - wrench_at_height(wrench[:, :2], centre, heights)[:, 5]
        return Loads(load, wrench[:, :2], centre, spin, area)

    def wrench(self, heights: Array) -> Array:
        """Return the wrenches (n, 6) over Young's modulus about the gel's origin; see `of`."""
        force = np.column_stack([self.shear, self.load])
        wrench = wrench_at(force, np.column_stack([self.centre, heights]))
        wrench[:, 5] += self.spin
        return wrench


def solved(play: Play) -> Mask:
    """Return the frames (n,) whose wrench is known: solved ones, and those without contact."""
    return np.isin(play.status, KNOWN)


def complete(plays: Sequence[Play], middle: Sequence[Play], heights: Sequence[Array]) -> list[Play]:
    """Return plays in which every frame that the middle play knows is known.

    Frames that the middle play does not know stay as they are. So do all missing frames of a play that has solved no
    contact in any touch.

    Parameters
    ----------
    plays : sequence of t Play
        Plays of t touches at one choice of parameters.
    middle : sequence of t Play
        Plays of the same touches at the middle of the grid.
    heights : sequence of (n,) m
        Height of the tip in the gel frame at the frames of each touch.
    """
    if all((solved(play) | ~solved(about)).all() for play, about in zip(plays, middle, strict=True)):
        return list(plays)
    known = [_Change.of(*pair) for pair in zip(plays, middle, heights, strict=True)]
    pooled = _Change.joined(known)
    return [
        _completed(play, about, change, pooled, height)
        for play, about, change, height in zip(plays, middle, known, heights, strict=True)
    ]


class _Change(NamedTuple):
    """How a play differs from the middle one at k frames that both have solved, in the order of the load.

    Parameters
    ----------
    load : (k,)
        Load of the middle play.
    factors : (k, 3)
        Factors on load, shear and area. Where the shear is too small to determine its factor, it has that of the load.
    motion : (k, 2) m
        Motion of the centre of pressure.
    """

    load: Array
    factors: Array
    motion: Array

    @staticmethod
    def of(play: Play, middle: Play, heights: Array) -> _Change:
        """Return the change at the frames in which both plays are in contact."""
        here, there = Loads.of(play, heights), Loads.of(middle, heights)
        rows = np.flatnonzero(solved(play) & solved(middle) & (here.load > 0) & (there.load > 0))
        rows = rows[np.argsort(there.load[rows], kind="stable")]
        load = there.load[rows]
        of_load = here.load[rows] / load
        squares = (there.shear[rows] ** 2).sum(axis=1)
        is_large = squares > (LEAST_SHEAR * load) ** 2
        along = (here.shear[rows] * there.shear[rows]).sum(axis=1)
        of_shear = np.divide(along, squares, out=of_load.copy(), where=is_large)
        of_area = np.divide(here.area[rows], there.area[rows], out=of_load.copy(), where=there.area[rows] > 0)
        return _Change(load, np.column_stack([of_load, of_shear, of_area]), here.centre[rows] - there.centre[rows])

    @staticmethod
    def joined(changes: Sequence[_Change]) -> _Change:
        """Return the changes of several touches together."""
        load = np.concatenate([change.load for change in changes])
        order = np.argsort(load, kind="stable")
        return _Change(
            load[order],
            np.concatenate([change.factors for change in changes])[order],
            np.concatenate([change.motion for change in changes])[order],
        )

    def at(self, loads: Array) -> tuple[Array, Array]:
        """Return factors (n, 3) and motion (n, 2), interpolated over the load; those of an end beyond it."""
        factors = np.column_stack([np.interp(loads, self.load, column) for column in self.factors.T])
        return factors, np.column_stack([np.interp(loads, self.load, column) for column in self.motion.T])

    def near(self, loads: Array) -> tuple[Array, Array]:
        """Return the median factors (n, 3) and motion (n, 2) of the ``NEIGHBOURS`` frames next in load."""
        nearest = np.argsort(np.abs(self.load - loads[:, None]), axis=1, kind="stable")[:, :NEIGHBOURS]
        return np.median(self.factors[nearest], axis=1), np.median(self.motion[nearest], axis=1)


def _completed(play: Play, middle: Play, change: _Change, pooled: _Change, heights: Array) -> Play:
    """Return one play with its missing frames estimated; see `complete`."""
    missing = solved(middle) & ~solved(play)
    if not missing.any():
        return play
    there = Loads.of(middle, heights)
    if len(change.load):
        factors, motion = change.at(there.load[missing])
    elif len(pooled.load):
        factors, motion = pooled.near(there.load[missing])
    else:
        return play
    touches = there.load[missing] > 0
    estimate = Loads(
        there.load[missing] * factors[:, 0],
        there.shear[missing] * factors[:, 1:2],
        there.centre[missing] + motion * touches[:, None],
        there.spin[missing] * factors[:, 1],
        there.area[missing] * factors[:, 2],
    )
    wrench, area, status = play.wrench.copy(), play.area.copy(), play.status.copy()
    wrench[missing], area[missing] = estimate.wrench(heights[missing]), estimate.area
    status[missing] = np.where(touches, FrameStatus.SOLVED, FrameStatus.NO_CONTACT)
    return Play(wrench, status, area)
