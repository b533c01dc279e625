"""A trial as touches that the simulation can play, with everything that effects may depend on."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.next_trial.bench import TrialBench
from tactiledata.diagnose.next_trial.path import FREE_AIR, TrialPath, trial_path
from tactiledata.diagnose.next_trial.trial import Trial, TrialTouch
from tactiledata.diagnose.touches.touch_case import TouchCase, TouchSet
from tactiledata.effects.touch.felt_acceleration import felt_accelerations
from tactiledata.effects.touch.imprint import ImprintTable, strongest_imprint
from tactiledata.effects.touch.touch import Touch

DOWN = (0.0, 0.0, -9.81)
"""Gravity, m/s^2, gel frame, where no recording states it."""
SAME_PLACE = 1.5e-3
"""Distance, m, within which two touches count as made at one place."""
POSES = 125.0
"""Rate of the robot's stream of poses, Hz."""


def trial_cases(trial: Trial, bench: TrialBench) -> TouchSet:
    """Return the touches of a trial. Their wrenches are those of the plain simulation; they only weigh the frames."""
    # poses and times of all touches; a new recording begins at time 0
    history = _SurfaceHistory(bench)
    since, touches = 0.0, []
    for number, planned in enumerate(trial.touches):
        if trial.per_recording and number % trial.per_recording == 0:
            since = 0.0
        path = trial_path(planned, trial.burst)
        touches.append(_touch(trial, planned, path, bench, since, history))
        since += path.duration + trial.pause
    # wrenches of the plain simulation
    blank = [_case(trial, number, touch, np.zeros((len(touch), 6)), bench) for number, touch in enumerate(touches)]
    plain = TouchSet(blank, bench.base).play(bench.material, [])
    rows = np.split(plain, np.cumsum([len(touch) for touch in touches])[:-1])
    cases = [_case(trial, number, touch, rows[number], bench) for number, touch in enumerate(touches)]
    return TouchSet(cases, bench.base)


def duration(trial: Trial) -> float:
    """Return the time that a trial takes, s, pauses included."""
    return sum(trial_path(touch).duration for touch in trial.touches) + trial.pause * (len(trial.touches) - 1)


def _case(trial: Trial, number: int, touch: Touch, measured: Array, bench: TrialBench) -> TouchCase:
    """Return a touch with the wrenches (n, 6), N and N m, that count as measured."""
    free = touch.tips[:, 2] > 0
    return TouchCase(touch, measured, bench.noise, free, bench.free_samples, f"{trial.name}-{number + 1}")


class _SurfaceHistory:
    """Imprints that touches have left on the gel's surface, and how often each place was touched."""

    def __init__(self, bench: TrialBench) -> None:
        usual = bench.touch
        depth = 0.0 if usual.earlier_depth is None else float(np.nanmax(usual.earlier_depth))
        self._bench, self._tables = bench, {usual.indenter_name: ImprintTable.of(usual.indenter)}
        imprint = float(self._tables[usual.indenter_name].imprint(depth))
        self._visits = [(np.asarray(place), imprint) for place in bench.visited]

    def before(self, place: tuple[float, float], indenter: str) -> tuple[float, int]:
        """Return how a place (x, y), m, was touched before.

        The first number is the depth, m, at which the given indenter would make the strongest imprint that is there;
        the second is the number of touches.
        """
        pressed = np.array([where for where, _ in self._visits]).reshape(-1, 2)
        strongest = strongest_imprint(np.array([place]), pressed, np.array([imprint for _, imprint in self._visits]))
        count = (np.linalg.norm(pressed - place, axis=1) < SAME_PLACE).sum()
        return float(self._table(indenter).depth(strongest)[0]), int(count)

    def touched(self, place: tuple[float, float], indenter: str, depth: float) -> None:
        """Add a touch of a place (x, y), m, to a depth, m."""
        self._visits.append((np.asarray(place), float(self._table(indenter).imprint(depth))))

    def _table(self, indenter: str) -> ImprintTable:
        """Return the imprint over depth of an indenter, computed once."""
        if indenter not in self._tables:
            self._tables[indenter] = ImprintTable.of(self._bench.indenter(indenter))
        return self._tables[indenter]


def _touch(
    trial: Trial, planned: TrialTouch, path: TrialPath, bench: TrialBench, since: float, history: _SurfaceHistory
) -> Touch:
    """Return a touch at the frames of its trial.

    Parameters
    ----------
    since : float
        Time from the start of the recording to the start of the touch, s.
    history : _SurfaceHistory
        The touches before this one; this one is added.
    """
    # times and poses of the frames
    seconds = path.captures if trial.capture == "step" else np.arange(0.5 / trial.rate, path.duration, 1.0 / trial.rate)
    seconds = np.unique(np.round(seconds, 6))
    places, turned = path.at(seconds)
    usual = bench.touch
    upright = usual.poses[0, :3, :3] if np.isfinite(usual.poses[0]).all() else np.eye(3)
    poses = np.tile(np.eye(4), (len(seconds), 1, 1))
    poses[:, :3, :3] = turned @ upright
    poses[:, :2, 3], poses[:, 2, 3] = places[:, :2], -places[:, 2]
    # gravity and joints
    down = np.asarray(DOWN) if usual.gravity is None else usual.gravity[0]
    joints = np.zeros((len(seconds), 6)) + (0.0 if usual.joints is None else usual.joints[0])
    # only a turn about the gel's normal is followed, by the last joint; other turns move several joints of the wrist
    joints[:, 5] += np.arctan2(turned[:, 1, 0], turned[:, 0, 0])
    # what was done to the place before
    depth, count = history.before(planned.position, planned.indenter)
    deepest = max(float(path.positions[:, 2].max()), 0.0)
    if deepest > 0:
        history.touched(planned.position, planned.indenter, deepest)
    return Touch(
        seconds=since + seconds,
        poses=poses,
        indenter=bench.indenter(planned.indenter),
        material=bench.material,
        geometry=usual.geometry,
        sensor=usual.sensor,
        indenter_name=planned.indenter,
        mount=planned.indenter if planned.indenter != usual.indenter_name else usual.mount,
        gravity=np.einsum("nij,j->ni", turned, down),
        joints=joints,
        powered=trial.powered + since + seconds,
        earlier_depth=np.full(len(seconds), depth),
        earlier_contacts=np.full(len(seconds), float(count)),
        selection=usual.selection,
        tare=seconds <= FREE_AIR,
        felt_accelerations=felt_accelerations(seconds, *_stream(path)),
    )


def _stream(path: TrialPath) -> tuple[Array, Array]:
    """Return times (m,), s, and tips (m, 3), m, gel frame, of the robot's stream of poses."""
    seconds = np.arange(0.0, path.duration, 1.0 / POSES)
    places, _ = path.at(seconds)
    return seconds, places * [1.0, 1.0, -1.0]
