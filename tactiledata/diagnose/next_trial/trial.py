"""A trial: a few touches that could be recorded next, in the terms of a scenario.

A step is a dictionary of one entry, its kind -> its numbers, as ``schemas/scenario.json`` has those of a trajectory.
Numbers are not checked here but where the scenario is read. `path` says how a robot follows the steps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

Step = dict[str, dict[str, Any]]
"""One step of a touch: kind -> numbers."""
Steps = tuple[Step, ...]


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


def press(depth: float, speed: float, step: float = ONE_MOVE, settle: float = 0.1) -> Step:
    """Return the step ``press``, which moves the indenter's tip to a depth, or back to a smaller one.

    It moves along the gel's normal, at the place where the indenter is. From free air it first turns a sensor back that
    was turned, and goes down to the surface. The trial's frames or bursts (`Trial.capture`) are taken after each
    ``step`` of the way and at its end.

    Parameters
    ----------
    depth : float
        Depth of the tip below the undeformed surface, m, above 0.
    speed : float
        Mean speed, m/s.
    step : float
        Length, m, after which the motion pauses for a frame or a burst.
    settle : float
        Rest before each frame or burst, s.
    """
    return {"press": {"depth": round(depth, 6), "step": round(step, 7), "speed": speed, "settle": settle}}


def dwell(seconds: float, frames: int) -> Step:
    """Return the step ``dwell``, which rests for ``seconds``, s, where the indenter is.

    Its ``frames`` single frames are evenly spaced, the last one at the end of the rest.
    """
    return {"dwell": {"time": seconds, "captures": frames}}


def shear(x: float, y: float, speed: float, step: float = ONE_MOVE, settle: float = 0.0) -> Step:
    """Return the step ``shear``, which moves the indenter along the gel at its depth, in the gel or in free air.

    Frames or bursts are taken after each ``step`` of the way and at its end.

    Parameters
    ----------
    x, y : float
        Displacement of the indenter, m, gel frame, from where it is.
    speed : float
        Mean speed, m/s.
    step : float
        Length, m, after which the motion pauses for a frame or a burst.
    settle : float
        Rest before each frame or burst, s.
    """
    return {"shear": {"by": [x, y], "step": round(step, 7), "speed": speed, "settle": settle}}


def turn(x: float, y: float, z: float, settle: float = 1.0) -> Step:
    """Return the step ``turn``, which turns the sensor in free air and takes a frame or a burst after a rest.

    An indenter nearer to the gel than 20 mm first leaves it by that much. The turn is about the indenter's tip, at 0.5
    rad/s. It is not added to an earlier turn: zeros turn back, and so do the next press, a retreat and the touch's end.

    Parameters
    ----------
    x, y, z : float
        Rotation vector, rad, of the indenter as the gel sees it (gel frame), from the orientation in which the touch
        presses; the indenter stands, so that the sensor turns the other way. A scenario allows -1.6 to 1.6 for each.
    settle : float
        Rest before the frame or burst, s.
    """
    return {"turn": {"to": [x, y, z], "speed": 0.5, "settle": settle}}


def retreat(speed: float) -> Step:
    """Return the step ``retreat``, which leaves the gel along its normal and takes no frame by itself.

    ``speed``, m/s, is the mean speed up to the surface; from there on the indenter rises by 2 mm at the usual one.
    """
    return {"retreat": {"speed": speed}}
