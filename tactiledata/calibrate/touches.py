"""Touches that were measured: poses, indenter, contact wrench and what is known of the force sensor's zero."""

from __future__ import annotations

from dataclasses import dataclass

from tactiledata.arrays import Array
from tactiledata.gel.contact.history import GelTouch


@dataclass(frozen=True)
class MeasuredTouch:
    """One trajectory.

    Parameters
    ----------
    uid, name, sensor, indenter : str
    touch : GelTouch
        n frames.
    wrench : (n, 6) N, N m
        Contact wrench at the frames, gel frame, about the gel's origin: pressing gives fz > 0; NaN where not known.
    seconds : (n,) s, from the trajectory's start
    free_samples : float
        Samples in free air before the touch, from which its zero was taken.
    """

    uid: str
    name: str
    sensor: str
    indenter: str
    touch: GelTouch
    wrench: Array
    seconds: Array
    free_samples: float

    def deeper(self, offset: float) -> GelTouch:
        """The touch with the indenter deeper by an offset, m, along the gel frame's -z."""
        poses = self.touch.poses.copy()
        poses[:, 2, 3] -= offset
        return GelTouch(self.touch.indenter, poses)
