"""Path of the indenter in a touch of a trial, as a robot that follows the scenario moves it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tactiledata.arrays import Array
from tactiledata.diagnose.next_trial.trial import TrialTouch

FREE_AIR, FREE_AIR_AFTER = 0.6, 0.4
"""Rest before and after each touch, s."""
CLEARANCE, TURNING_CLEARANCE = 2e-3, 2e-2
"""Heights above the gel between touches and where the sensor turns, m."""
APPROACH_SPEED, TURNING_SPEED = 5e-3, 0.5
"""Speeds in free air, m/s and rad/s."""
FREE_FRAMES = 3
"""Frames before first contact."""
SPACING = 1.0 / 30.0
"""Time between the frames of a burst, s."""


@dataclass(frozen=True)
class TrialPath:
    """A trajectory through k knots, with a smooth step (zero speed at each knot) from one to the next.

    Parameters
    ----------
    times : (k,) s
        Time of each knot.
    positions : (k, 3) m
        x and y on the gel, and depth below its undeformed surface.
    turns : (k, 3) rad
        Rotation vectors of the indenter, gel frame, from its orientation in a press; zero near the gel.
    captures : (c,) s
        Times of the frames that are taken step by step.
    """

    times: Array
    positions: Array
    turns: Array
    captures: Array

    @property
    def duration(self) -> float:
        """Duration of the path, s."""
        return float(self.times[-1])

    def at(self, seconds: Array) -> tuple[Array, Array]:
        """Return positions (n, 3), m, and rotations (n, 3, 3) at times (n,), s."""
        index = np.clip(np.searchsorted(self.times, seconds, side="right") - 1, 0, len(self.times) - 2)
        share = np.clip((seconds - self.times[index]) / np.maximum(np.diff(self.times)[index], 1e-12), 0.0, 1.0)
        smooth = (share**2 * (3.0 - 2.0 * share))[:, None]
        places, turns = (
            knots[index] + smooth * (knots[index + 1] - knots[index]) for knots in (self.positions, self.turns)
        )
        return places, Rotation.from_rotvec(turns).as_matrix()


def trial_path(touch: TrialTouch, burst: int = 1) -> TrialPath:
    """Return the path of one touch of a trial, with ``burst`` frames after each step."""
    knots = _Knots(touch, burst)
    for step in touch.steps:
        ((kind, numbers),) = step.items()
        knots.follow(kind, numbers)
    knots.leave(APPROACH_SPEED, CLEARANCE)
    knots.wait(FREE_AIR_AFTER)
    return TrialPath(np.array(knots.times), np.array(knots.places), np.array(knots.turns), np.array(knots.captures))


class _Knots:
    """Knots of a path, added in order of time, from a rest above the gel on."""

    def __init__(self, touch: TrialTouch, burst: int) -> None:
        self.burst = burst
        self.times: list[float] = [0.0]
        self.places: list[Array] = [np.array([*touch.position, -CLEARANCE])]
        self.turns: list[Array] = [np.zeros(3)]
        self.captures: list[float] = []
        self.last_shear = np.zeros(3)
        self.wait(FREE_AIR)
        self.capture(FREE_FRAMES)

    @property
    def here(self) -> Array:
        """Position (3,) of the last knot, m: x, y and depth."""
        return self.places[-1]

    def follow(self, kind: str, numbers: dict[str, Any]) -> None:
        """Add one step of the scenario: its kind, and its numbers as in ``schemas/scenario.json``."""
        if kind == "press":
            self.upright()
            if self.here[2] < 0:
                self.move(np.array([*self.here[:2], 0.0]), APPROACH_SPEED)
            self.stepwise(np.array([*self.here[:2], numbers["depth"]]), numbers)
        elif kind == "shear":
            self.last_shear = np.array([*numbers["by"], 0.0])
            self.stepwise(self.here + self.last_shear, numbers)
        elif kind == "reverse":
            self.stepwise(self.here - self.last_shear, numbers)
        elif kind == "dwell":
            for _ in range(numbers["captures"]):
                self.wait(numbers["time"] / numbers["captures"])
                self.capture(1)
        elif kind == "turn":
            if self.here[2] > -TURNING_CLEARANCE:
                self.leave(APPROACH_SPEED, TURNING_CLEARANCE)
            self.turn(np.array(numbers["to"]), numbers["speed"])
            self.wait(numbers["settle"])
            self.capture(self.burst)
        else:
            self.leave(numbers["speed"], CLEARANCE)

    def stepwise(self, to: Array, numbers: dict[str, Any]) -> None:
        """Move to a position (3,), m, with a rest and a burst of frames after each ``step`` of the way."""
        start, whole = self.here, float(np.linalg.norm(to - self.here))
        if whole < 1e-9:
            return
        for mark in np.append(np.arange(numbers["step"], whole - 1e-9, numbers["step"]), whole) / whole:
            self.move(start + mark * (to - start), numbers["speed"])
            self.wait(numbers["settle"])
            self.capture(self.burst)

    def leave(self, speed: float, clearance: float) -> None:
        """Leave the gel at a speed, m/s, and rise to a clearance, m, above its surface."""
        self.upright()
        if self.here[2] > 0:
            self.move(np.array([*self.here[:2], 0.0]), speed)
        self.move(np.array([*self.here[:2], -clearance]), APPROACH_SPEED)

    def upright(self) -> None:
        """Turn the sensor back to its orientation at touch."""
        self.turn(np.zeros(3), TURNING_SPEED)

    def move(self, to: Array, speed: float) -> None:
        """Move to a position (3,), m, at a mean speed, m/s."""
        self._add(float(np.linalg.norm(to - self.here)) / speed, to, self.turns[-1])

    def turn(self, to: Array, speed: float) -> None:
        """Turn to a rotation vector (3,), rad, at a mean speed, rad/s."""
        self._add(float(np.linalg.norm(to - self.turns[-1])) / speed, self.here, to)

    def capture(self, count: int) -> None:
        """Take a burst of frames, the last one at the last knot."""
        self.captures.extend(self.times[-1] - SPACING * np.arange(count)[::-1])

    def wait(self, seconds: float) -> None:
        """Rest at the last knot."""
        self._add(seconds, self.here, self.turns[-1])

    def _add(self, seconds: float, place: Array, turn: Array) -> None:
        """Add a knot some seconds after the last one; none where no time passes."""
        if seconds > 1e-9:
            self.times.append(self.times[-1] + seconds)
            self.places.append(place)
            self.turns.append(turn)
