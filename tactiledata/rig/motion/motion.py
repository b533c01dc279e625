"""Motion of the indenter over the gel in one touch, and the poses of the arm that bring it about."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from tactiledata.arrays import RealArray
from tactiledata.rig.motion.touch import Step, TouchPlan
from tactiledata.transforms import Transform

CLEARANCE = 2e-3
"""Distance between gel and indenter before and after a touch, m."""
APPROACH_SPEED = 5e-3
"""Speed through free air, m/s."""
FREE_AIR = 0.6
"""Time at rest in free air at the start of every trajectory, s: enough to see bias and noise before the touch."""
FREE_AIR_AFTER = 0.4
"""Time at rest in free air at the end of every trajectory, s."""
TURNING_CLEARANCE = 2e-2
"""Distance between gel and indenter while the sensor turns, m."""
TURNING_SPEED = 0.5
"""Speed of turning back to the touch's own orientation, rad/s."""


@dataclass(frozen=True)
class Path:
    """The commanded motion of the indenter over the gel in one trajectory.

    Parameters
    ----------
    times : (k,) seconds from the trajectory's start
        Ends of the moves; between two of them the position follows a smooth step.
    positions : (k, 3) metres
        x, y of the indenter's tip on the gel; depth of its lowest point below the undeformed surface (negative: air).
    captures : (c,) seconds
        Moments at which pictures are taken.
    phases : tuple of (start, end, name)
        Parts of the trajectory, in seconds; names ``free``, ``press``, ``dwell``, ``shear``, ``reverse``, ``turn`` and
        ``retreat``.
    turns : (k, 3) rad
        Rotation vectors, gel axes, of the indenter at the ends of the moves, on top of the touch's own orientation;
        zero wherever the indenter is near the gel.
    """

    times: RealArray
    positions: RealArray
    captures: RealArray
    phases: tuple[tuple[float, float, str], ...]
    turns: RealArray

    @property
    def duration(self) -> float:
        """Duration of the trajectory in seconds."""
        return float(self.times[-1])

    def at(self, times: RealArray) -> RealArray:
        """Return positions (n, 3), x, y and depth in metres, at seconds (n,), held at both ends."""
        index, share = self._progress(times)
        return self.positions[index] + share[:, None] * (self.positions[index + 1] - self.positions[index])

    def turned(self, times: RealArray) -> RealArray:
        """Return rotations (n, 3, 3), gel axes, on top of the touch's own orientation, at seconds (n,)."""
        if not self.turns.any():
            return np.broadcast_to(np.eye(3), (len(times), 3, 3))
        index, share = self._progress(times)
        vectors = self.turns[index] + share[:, None] * (self.turns[index + 1] - self.turns[index])
        return Rotation.from_rotvec(vectors).as_matrix()

    def travelled(self, times: RealArray) -> RealArray:
        """Return the lengths (n,), metres, of the path from its start up to seconds (n,)."""
        index, share = self._progress(times)
        lengths = np.linalg.norm(np.diff(self.positions, axis=0), axis=1)
        return (np.cumsum(lengths) - lengths)[index] + share * lengths[index]

    def _progress(self, times: RealArray) -> tuple[NDArray[np.intp], RealArray]:
        """Return the index of the move (n,) at seconds (n,), and the share of it that is done (n,)."""
        index = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, len(self.times) - 2)
        span = np.maximum(np.diff(self.times)[index], 1e-12)
        share = np.clip((times - self.times[index]) / span, 0.0, 1.0)
        # a smooth step has no jump of velocity, so joints and forces have none either
        return index, share * share * (3.0 - 2.0 * share)


class _Recorder:
    """Builds a `Path` move by move, from a position (3,): x, y and depth in metres."""

    def __init__(self, start: RealArray) -> None:
        self.times = [0.0]
        self.positions: list[RealArray] = [start]
        self.turns: list[RealArray] = [np.zeros(3)]
        self.captures: list[float] = []
        self.phases: list[tuple[float, float, str]] = []

    def hold(self, seconds: float) -> None:
        """Stay in place for some seconds."""
        if seconds > 0:
            self._append(seconds, self.positions[-1], self.turns[-1])

    def move(self, to: RealArray, speed: float) -> None:
        """Move straight to a position (3,), m, at a mean speed, m/s."""
        distance = float(np.linalg.norm(to - self.positions[-1]))
        if distance > 1e-12:
            self._append(distance / speed, to, self.turns[-1])

    def turn(self, to: RealArray, speed: float) -> None:
        """Turn to a rotation vector (3,), rad, at a mean speed, rad/s."""
        angle = float(np.linalg.norm(to - self.turns[-1]))
        if angle > 1e-12:
            self._append(angle / speed, self.positions[-1], to)

    def upright(self) -> None:
        """Turn back to the touch's own orientation."""
        self.turn(np.zeros(3), TURNING_SPEED)

    def _append(self, seconds: float, position: RealArray, turn: RealArray) -> None:
        self.times.append(self.times[-1] + seconds)
        self.positions.append(position)
        self.turns.append(turn)

    def capture(self, count: int, spacing: float = 1.0 / 30.0) -> None:
        """Take ``count`` pictures, ``spacing`` seconds apart, of which the last one is taken now."""
        # the last picture comes at the end of the settling time, earlier ones a camera period apart
        self.captures.extend(self.times[-1] - spacing * np.arange(count)[::-1])

    def phase(self, name: str, since: float) -> None:
        """Name the part of the trajectory from ``since``, s, until now."""
        self.phases.append((since, self.times[-1], name))


def plan(
    touch: TouchPlan, deepest: Callable[[float], float], frames_per_step: int = 1, free_air_frames: int = 1
) -> Path:
    """Return the path of one touch.

    Parameters
    ----------
    touch : TouchPlan
        Steps, place and limit of force.
    deepest : callable
        Gives the depth, m, at which the normal force reaches a limit, N; presses stop there.
    frames_per_step, free_air_frames : int
        Number of pictures after each step, and before the first contact.
    """
    # rest in free air, then approach, unless the touch begins by turning
    recorder = _Recorder(np.array([*touch.position, -CLEARANCE]))
    recorder.hold(FREE_AIR)
    if free_air_frames:
        recorder.capture(free_air_frames)
    if touch.steps[0].kind != "turn":
        recorder.move(np.array([*touch.position, 0.0]), APPROACH_SPEED)
    recorder.phase("free", 0.0)
    # the steps of the touch
    limit = deepest(touch.force_limit)
    last_shear = (0.0, 0.0)
    for step in touch.steps:
        since = recorder.times[-1]
        here = recorder.positions[-1]
        if step.kind == "press":
            recorder.upright()
            if here[2] < 0:
                # after a retreat: through the air at once, then step by step
                here = np.array([here[0], here[1], 0.0])
                recorder.move(here, APPROACH_SPEED)
            to = np.array([here[0], here[1], min(step.depth, limit)])
            _stepwise(recorder, to, step, frames_per_step)
        elif step.kind == "shear":
            last_shear = step.by
            _stepwise(recorder, here + np.array([*step.by, 0.0]), step, frames_per_step)
        elif step.kind == "reverse":
            _stepwise(recorder, here - np.array([*last_shear, 0.0]), step, frames_per_step)
        elif step.kind == "dwell":
            _dwell(recorder, step)
        elif step.kind == "turn":
            _turn(recorder, step, frames_per_step)
        else:
            _retreat(recorder, step.speed)
        recorder.phase(step.kind, since)
    # leave the gel and rest
    since = recorder.times[-1]
    if recorder.positions[-1][2] != -CLEARANCE:
        _retreat(recorder, APPROACH_SPEED)
        recorder.phase("retreat", since)
        since = recorder.times[-1]
    recorder.hold(FREE_AIR_AFTER)
    recorder.phase("free", since)
    return Path(
        np.array(recorder.times),
        np.array(recorder.positions),
        np.array(recorder.captures),
        tuple(recorder.phases),
        np.array(recorder.turns),
    )


def _stepwise(recorder: _Recorder, to: RealArray, step: Step, captures: int) -> None:
    """Move to a position (3,), m, in steps, each followed by a time of rest and pictures."""
    start = recorder.positions[-1]
    total = float(np.linalg.norm(to - start))
    if total < 1e-9:
        return
    # steps of the stated length, the last one whatever is left of it
    marks = np.append(np.arange(step.step, total - 1e-9, step.step), total) / total
    for mark in marks:
        recorder.move(start + mark * (to - start), step.speed)
        recorder.hold(step.settle)
        recorder.capture(captures)


def _dwell(recorder: _Recorder, step: Step) -> None:
    """Rest for the step's time, with pictures evenly spaced in it."""
    for _ in range(max(step.captures, 1)):
        recorder.hold(step.time / max(step.captures, 1))
        if step.captures:
            recorder.capture(1)


def _turn(recorder: _Recorder, step: Step, captures: int) -> None:
    """Turn the sensor, well above the gel, then rest and take pictures."""
    if recorder.positions[-1][2] > -TURNING_CLEARANCE:
        _retreat(recorder, APPROACH_SPEED, TURNING_CLEARANCE)
    recorder.turn(np.array(step.to), step.speed)
    recorder.hold(step.settle)
    recorder.capture(captures)


def _retreat(recorder: _Recorder, speed: float, clearance: float = CLEARANCE) -> None:
    """Leave the gel upright at a speed, m/s, and go on through air up to a clearance, m."""
    recorder.upright()
    here = recorder.positions[-1]
    if here[2] > 0:
        recorder.move(np.array([here[0], here[1], 0.0]), speed)
    recorder.move(np.array([here[0], here[1], -clearance]), APPROACH_SPEED)


def gel_from_indenter_rotation(touch: TouchPlan) -> RealArray:
    """Return the rotation gel_from_indenter (3, 3) of a touch: yaw about gel z, then tilt about gel x and y."""
    tilt = Rotation.from_rotvec([touch.tilt[0], touch.tilt[1], 0.0])
    return (tilt * Rotation.from_euler("z", touch.yaw)).as_matrix()


def base_from_tcp(
    path_positions: RealArray,
    rotation: RealArray,
    lowest: float,
    base_from_indenter: Transform,
    tcp_from_gel: Transform,
) -> RealArray:
    """Return the poses base_from_tcp (n, 4, 4), metres, at which the indenter has given positions over the gel.

    Parameters
    ----------
    path_positions : (n, 3), metres
        x, y of the indenter's tip over the gel and depth of its first-touching point.
    rotation : (3, 3) or (n, 3, 3)
        Orientation of the indenter, gel_from_indenter.
    lowest : metres
        Height of the first-touching point of the turned indenter over its tip, along gel z; at most 0.
    base_from_indenter : Transform
        Pose of the mounted indenter.
    tcp_from_gel : Transform
        Mounting of the sensor on the arm.
    """
    count = len(path_positions)
    gel_from_indenter = np.tile(np.eye(4), (count, 1, 1))
    gel_from_indenter[:, :3, :3] = rotation
    gel_from_indenter[:, :2, 3] = path_positions[:, :2]
    gel_from_indenter[:, 2, 3] = -path_positions[:, 2] - lowest
    indenter_from_gel = np.linalg.inv(gel_from_indenter)
    return base_from_indenter.matrix @ indenter_from_gel @ tcp_from_gel.inverse().matrix


def transit(start: RealArray, end: RealArray, share: RealArray, lift: float = 0.02) -> RealArray:
    """Return the poses base_from_tcp (n, 4, 4) between two touches: up from the table, over and down.

    Parameters
    ----------
    start, end : (4, 4), metres
        Poses base_from_tcp at both ends.
    share : (n,)
        Shares of the time that have passed, 0 to 1.
    lift : metres
        Height of the arc above the straight line.
    """
    smooth = share * share * (3.0 - 2.0 * share)
    poses = np.tile(np.eye(4), (len(share), 1, 1))
    poses[:, :3, 3] = start[:3, 3] + smooth[:, None] * (end[:3, 3] - start[:3, 3])
    poses[:, 2, 3] += lift * np.sin(np.pi * smooth)
    poses[:, :3, :3] = Slerp([0.0, 1.0], Rotation.from_matrix([start[:3, :3], end[:3, :3]]))(smooth).as_matrix()
    return poses
