"""A measured touch: poses, indenter, contact wrench, and from how many samples its force zero was taken."""

from __future__ import annotations

from dataclasses import dataclass

from tactiledata.arrays import Array, Indices
from tactiledata.gel.contact.history import GelTouch


@dataclass(frozen=True)
class ForceReadings:
    """Readings of a force sensor at its own rate during one trajectory.

    Parameters
    ----------
    seconds : (m,) s, ascending
        Time from the first frame of the trajectory.
    wrench : (m, 6) N, N m
        In the same frame of reference as the wrenches of frames; NaN where unknown.
    """

    seconds: Array
    wrench: Array


@dataclass(frozen=True)
class MeasuredTouch:
    """One measured trajectory of n frames, as a calibration uses it.

    Parameters
    ----------
    uid, name, sensor, indenter : str
        Identity and name of the trajectory, names of the sensor and the indenter.
    touch : GelTouch
        Poses of n frames, and the indenter.
    wrench : (n, 6) N, N m
        Contact wrench at the frames, gel frame, about the gel's origin: pressing gives fz > 0; NaN where not known.
    seconds : (n,) s
        Time from the trajectory's start.
    free_samples : float
        Number of samples in free air before the touch, from which its zero was taken.
    frames : (n,), optional
        Numbers of the frames among those of the trajectory; all of them, in order, where ``None``.
    readings : ForceReadings, optional
        The force sensor's readings during the trajectory, where they are known.
    """

    uid: str
    name: str
    sensor: str
    indenter: str
    touch: GelTouch
    wrench: Array
    seconds: Array
    free_samples: float
    frames: Indices | None = None
    readings: ForceReadings | None = None

    def deeper(self, offset: float) -> GelTouch:
        """Return the touch with the indenter deeper by ``offset``, m, along the gel frame's -z."""
        poses = self.touch.poses.copy()
        poses[:, 2, 3] -= offset
        return GelTouch(self.touch.indenter, poses)
