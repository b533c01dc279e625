"""Commands to the arm: one touch and its steps, or the ranges from which touches are drawn."""

from __future__ import annotations

from dataclasses import dataclass

Range = tuple[float, float]
"""Least and largest value of a range from which values are drawn."""


@dataclass(frozen=True)
class Step:
    """One part of a touch, of a kind that decides which of the other fields count.

    Parameters
    ----------
    kind : str
        ``press`` to ``depth``, ``shear`` by ``by`` or ``reverse`` (the last shear backwards), all in small steps;
        ``dwell`` at rest; ``turn`` well above the gel; ``retreat`` out of the gel and back to the touch's orientation.
    depth : metres
        Depth below the undeformed surface that a press goes to.
    by : (2,), metres
        Move along gel x and y in a shear.
    step : metres
        Length of a small step.
    speed : m/s, of a turn rad/s
        Mean speed of a step.
    settle : s
        Time of rest after each step, at whose end pictures are taken.
    time, captures : s and int
        Duration of a dwell, and the number of pictures in it.
    to : (3,), rad
        Rotation vector, gel axes, that a turn goes to.
    """

    kind: str
    depth: float = 0.0
    by: tuple[float, float] = (0.0, 0.0)
    step: float = 1e-4
    speed: float = 1e-3
    settle: float = 0.15
    time: float = 0.0
    captures: int = 2
    to: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class TouchPlan:
    """The plan of one trajectory: which indenter touches which sensor, where, at which angle, in which steps.

    Parameters
    ----------
    name : str
        Name of the trajectory.
    sensor, indenter : str
        Names in the scenario.
    steps : tuple of Step
        What the arm does, in order.
    position : (2,), metres
        Place of the indenter's tip at first touch, gel frame.
    tilt : (2,), rad
        Rotation of the indenter about gel x and y, relative to head-on.
    yaw : rad
        Rotation of the indenter about gel z.
    force_limit : N
        Largest force that a press may reach.
    group : str
        Name of the touch where several sensors share it; empty for none.
    """

    name: str
    sensor: str
    indenter: str
    steps: tuple[Step, ...]
    position: tuple[float, float] = (0.0, 0.0)
    tilt: tuple[float, float] = (0.0, 0.0)
    yaw: float = 0.0
    force_limit: float = 13.0
    group: str = ""


@dataclass(frozen=True)
class Generate:
    """The ranges from which touches are drawn at random; units and meaning in ``schemas/scenario.json``.

    Parameters
    ----------
    count : int
        Number of draws.
    paired : bool or int
        Whether every touch is made on every sensor; a number: the first ``paired`` touches are.
    paired_indenters, paired_sensors : tuple of str
        Indenters and sensors of paired touches; empty for all of ``indenters`` and ``sensors``.
    sensors, indenters : tuple of str
        Those that take part; empty for all of the scenario.
    speeds : tuple of float, m/s
        Values that are drawn from instead of the range ``speed``.
    """

    count: int
    paired: bool | int = False
    paired_indenters: tuple[str, ...] = ()
    paired_sensors: tuple[str, ...] = ()
    sensors: tuple[str, ...] = ()
    indenters: tuple[str, ...] = ()
    depth: Range = (0.0006, 0.0013)
    force_limit: float = 13.0
    step: float = 1e-4
    settle: Range = (0.1, 0.2)
    speed: Range = (0.5e-3, 2e-3)
    speeds: tuple[float, ...] = ()
    dwell: Range = (0.2, 0.6)
    tilt: Range = (0.0, 0.12)
    position: tuple[float, float] = (0.0025, 0.0040)
    shear: Range = (0.0003, 0.0008)
    shear_share: float = 0.5
    reverse_share: float = 0.4
    shear_step: float = 1e-4
