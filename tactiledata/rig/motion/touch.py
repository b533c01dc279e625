"""What the arm is told to do: one touch and its steps, or the ranges from which touches are drawn."""

from __future__ import annotations

from dataclasses import dataclass

Range = tuple[float, float]


@dataclass(frozen=True)
class Step:
    """One part of a touch.

    ``press`` to ``depth``, ``shear`` by ``by``, ``reverse`` (the last shear backwards): in steps of ``step`` at mean
    ``speed``, each followed by ``settle`` seconds and a capture. ``dwell``: ``time`` seconds with ``captures``
    pictures. ``turn``: in free air, well above the gel, to the rotation vector ``to`` at ``speed`` (rad/s), then
    ``settle`` seconds and a capture. ``retreat``: out of the gel, and back to the touch's own orientation.
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
    """One trajectory: which indenter touches which sensor where, at which angle, and the steps.

    ``position``: m, gel frame, of the indenter's tip at first touch; ``tilt`` about gel x and y and ``yaw`` about gel
    z: rad, of the indenter relative to head-on. ``group`` names the touch that several sensors share.
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
    """Touches drawn at random; ranges as [least, most]. ``speeds``: m/s, drawn from instead of the range.

    ``paired``: every touch is made on every sensor; a number: the first so many are, with ``paired_indenters`` and on
    ``paired_sensors`` where those are given.
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
