"""A trial: a few touches that could be recorded next, in the words of a scenario."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

Steps = tuple[dict[str, dict[str, Any]], ...]


@dataclass(frozen=True)
class TrialTouch:
    """One trajectory of a trial.

    Parameters
    ----------
    indenter : str
        Name at the bench.
    steps : tuple of dict
        As ``schemas/scenario.json`` has them, every number stated.
    position : (x, y) m
        Of the indenter's tip on the gel at first touch.
    """

    indenter: str
    steps: Steps
    position: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Trial:
    """What to record.

    Parameters
    ----------
    name, title : str
        In the registry; for people, an order with its numbers.
    touches : tuple of TrialTouch
    capture : "step" or "video"
        ``burst`` frames after each step, a thirtieth of a second apart, or frames at ``rate`` all the time.
    rate : Hz
    burst : int
    pause : s between touches
    powered : s since power-on when a recording starts
    per_recording : int, optional
        A new recording begins after so many touches, its sensor freshly switched on; all are in one where ``None``.
    caveat : str
        What of it the rig cannot play, or the estimate cannot tell.
    """

    name: str
    title: str
    touches: tuple[TrialTouch, ...]
    capture: Literal["step", "video"] = "step"
    rate: float = 10.0
    burst: int = 1
    pause: float = 2.0
    powered: float = 1200.0
    per_recording: int | None = None
    caveat: str = ""


ONE_MOVE = 0.01
"""m: a step that is longer than any way."""


def press(depth: float, speed: float, step: float = ONE_MOVE, settle: float = 0.1) -> dict[str, dict[str, Any]]:
    """To a depth, m, or back to a lesser one, at a mean speed, m/s; with a frame, or a burst, after each step, m."""
    return {"press": {"depth": round(depth, 6), "step": round(step, 7), "speed": speed, "settle": settle}}


def dwell(seconds: float, frames: int) -> dict[str, dict[str, Any]]:
    """At rest."""
    return {"dwell": {"time": seconds, "captures": frames}}


def shear(x: float, y: float, speed: float, step: float = ONE_MOVE, settle: float = 0.0) -> dict[str, dict[str, Any]]:
    """By (x, y), m, over the gel, in the same way."""
    return {"shear": {"by": [x, y], "step": round(step, 7), "speed": speed, "settle": settle}}


def turn(x: float, y: float, z: float, settle: float = 1.0) -> dict[str, dict[str, Any]]:
    """In free air, to a rotation vector, rad, of the gel's axes."""
    return {"turn": {"to": [x, y, z], "speed": 0.5, "settle": settle}}


def retreat(speed: float) -> dict[str, dict[str, Any]]:
    """Out of the gel at a speed, m/s."""
    return {"retreat": {"speed": speed}}
