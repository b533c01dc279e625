"""A trial: a few touches that could be recorded next, in the terms of a scenario."""

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
        Name of the indenter at the bench.
    steps : tuple of dict
        Steps as in ``schemas/scenario.json``, every number stated.
    position : (x, y) m
        Place of the indenter's tip on the gel at first touch, gel frame.
    """

    indenter: str
    steps: Steps
    position: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Trial:
    """A recording that is proposed.

    Parameters
    ----------
    name : str
        Name in the registry of trials.
    title : str
        An instruction for people, with its numbers.
    touches : tuple of TrialTouch
    capture : "step" or "video"
        Either ``burst`` frames after each step, a thirtieth of a second apart, or frames at ``rate`` all the time.
    rate : float
        Frames of a video, Hz.
    burst : int
        Frames after each step.
    pause : float
        Time between two touches, s.
    powered : float
        Time since power-on of the sensor when a recording starts, s.
    per_recording : int, optional
        Number of touches after which a new recording begins with its sensor freshly switched on; ``None``: one
        recording holds all touches.
    caveat : str
        What the rig cannot play, or the estimate cannot know; empty where there is nothing.
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
"""Step, m, that is longer than any press or slide: the move is made in one step."""


def press(depth: float, speed: float, step: float = ONE_MOVE, settle: float = 0.1) -> dict[str, dict[str, Any]]:
    """Return the step that presses to a depth, or goes back to a smaller one.

    Parameters
    ----------
    depth : float
        Depth below the undeformed surface, m.
    speed : float
        Mean speed, m/s.
    step : float
        Length, m, after which the motion pauses for a frame or a burst.
    settle : float
        Rest before each frame or burst, s.
    """
    return {"press": {"depth": round(depth, 6), "step": round(step, 7), "speed": speed, "settle": settle}}


def dwell(seconds: float, frames: int) -> dict[str, dict[str, Any]]:
    """Return the step that rests for some seconds and takes evenly spaced frames."""
    return {"dwell": {"time": seconds, "captures": frames}}


def shear(x: float, y: float, speed: float, step: float = ONE_MOVE, settle: float = 0.0) -> dict[str, dict[str, Any]]:
    """Return the step ``shear`` of ``schemas/scenario.json``, which moves the indenter along the gel.

    Parameters
    ----------
    x, y : float
        Displacement, m, gel frame.
    speed : float
        Mean speed, m/s.
    step : float
        Length, m, after which the motion pauses for a frame or a burst.
    settle : float
        Rest before each frame or burst, s.
    """
    return {"shear": {"by": [x, y], "step": round(step, 7), "speed": speed, "settle": settle}}


def turn(x: float, y: float, z: float, settle: float = 1.0) -> dict[str, dict[str, Any]]:
    """Return the step that turns the sensor in free air.

    Parameters
    ----------
    x, y, z : float
        Rotation vector, rad, of the gel's axes from their orientation at touch.
    settle : float
        Rest before the frame or burst, s.
    """
    return {"turn": {"to": [x, y, z], "speed": 0.5, "settle": settle}}


def retreat(speed: float) -> dict[str, dict[str, Any]]:
    """Return the step that leaves the gel at a speed, m/s."""
    return {"retreat": {"speed": speed}}
