"""Hidden loads on the force sensor: another weight of the tool, a cable, inertia."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from scipy.signal import cont2discrete, lfilter

from tactiledata.arrays import RealArray
from tactiledata.rig.hidden.base import HiddenEffect, Parameters, Times
from tactiledata.rig.motion import ur5e
from tactiledata.rig.scenario.scenario import Scenario
from tactiledata.transforms import move_wrench

if TYPE_CHECKING:
    from tactiledata.rig.play import PlayedLog

GRAVITY = 9.81
"""Acceleration of gravity, m/s²."""
CABLE_RATE = 50.0
"""Rate, Hz, at which the cable's friction is integrated."""
CABLE_SLIP = 0.02
"""Angle of the wrist, rad, over which the cable's friction changes its sign."""
CABLE_FORCE = (0.6, 0.64, 0.48)
"""Direction of the cable's pull, tool frame; a unit vector."""
CABLE_ARM = (0.0, 0.03, -0.06)
"""Point at which the cable pulls, m, tool frame."""
SHAKE_RATE = 500.0
"""Rate, Hz, at which accelerations are computed."""


@dataclass(frozen=True)
class HiddenToolWeight(HiddenEffect):
    """The tool is heavier than the log states, and its centre of gravity lies further along its axis.

    Parameters
    ----------
    mass : kg
        Mass beyond the stated one.
    lever : m
        Offset of the centre of gravity along the tool's z, and half of it along x.
    """

    NUMBER: ClassVar[str] = "15"
    ACTS: ClassVar[str] = "load"
    SOURCE: ClassVar[str] = "weight in the turning frame of the sensor"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"mass": 0.010, "lever": 0.002},
        "medium": {"mass": 0.030, "lever": 0.005},
        "strong": {"mass": 0.060, "lever": 0.010},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"mass": (-0.2, 0.5), "lever": (-0.05, 0.05)}
    mass: float = 0.0
    lever: float = 0.0

    def load(self, moments: Times, played_log: PlayedLog, scenario: Scenario) -> RealArray | None:
        """Return the weight (n, 6), N and N m, beyond the stated one, sensor frame.

        Parameters
        ----------
        moments : (n,), ns
            Sorted moments of the host clock.
        played_log : PlayedLog
            Motion of the arm.
        scenario : Scenario
            Mounting of the sensors, stated mass of the tool.
        """
        robot = scenario.robot
        down = -played_log.tcp(moments)[:, 2, :3]
        stated = np.asarray(robot.centre_of_gravity)
        real = stated + np.array([self.lever / 2, 0.0, self.lever])
        more = (robot.tool_mass + self.mass) * np.concatenate([down, np.cross(real, down)], axis=1)
        less = robot.tool_mass * np.concatenate([down, np.cross(stated, down)], axis=1)
        return move_wrench(GRAVITY * (more - less), robot.tcp_from_ft.inverse().matrix)


@dataclass(frozen=True)
class HiddenCableDrag(HiddenEffect):
    """A cable pulls at the tool: with the angles of the last two joints, and with hysteretic friction of the last one.

    F = force [0.5 sin q6 + 0.3 (q5 - pi / 2) + 0.7 z],
    dz = (dq6 / 0.02 rad) {1 - z² [0.5 + 0.5 sgn(z dq6)]}.

    Parameters
    ----------
    force : N
        Scale of the pull.
    """

    NUMBER: ClassVar[str] = "16"
    ACTS: ClassVar[str] = "load"
    SOURCE: ClassVar[str] = "Y.-K. Wen, J. Eng. Mech. Div. 102 (1976)"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"force": 0.05},
        "medium": {"force": 0.2},
        "strong": {"force": 0.5},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"force": (0.0, 5.0)}
    force: float = 0.0

    def load(self, moments: Times, played_log: PlayedLog, scenario: Scenario) -> RealArray | None:
        """Return the cable's pull (n, 6), N and N m, sensor frame.

        Parameters
        ----------
        moments : (n,), ns
            Sorted moments of the host clock.
        played_log : PlayedLog
            Motion of the arm.
        scenario : Scenario
            Mounting of the sensors.
        """
        grid = _grid(played_log, CABLE_RATE)
        robot = scenario.robot
        joints = ur5e.inverse(played_log.tcp(grid) @ robot.flange_from_tcp.inverse().matrix)
        size = 0.5 * np.sin(joints[:, 5]) + 0.3 * (joints[:, 4] - np.pi / 2) + 0.7 * bouc_wen(joints[:, 5] / CABLE_SLIP)
        at = self.force * np.interp(moments - grid[0], grid - grid[0], size)
        pull = at[:, None] * np.asarray(CABLE_FORCE)
        wrench = np.concatenate([pull, np.cross(np.asarray(CABLE_ARM), pull)], axis=1)
        return move_wrench(wrench, robot.tcp_from_ft.inverse().matrix)


def bouc_wen(displacement: RealArray) -> RealArray:
    """Return the hysteretic variable (n,), -1 to 1, of the Bouc-Wen model; 0 at the start.

    ``displacement`` (n,) counts in lengths over which friction changes its sign.
    """
    out = np.zeros(len(displacement))
    value = 0.0
    for moment, step in enumerate(np.diff(displacement).tolist(), start=1):
        # in pieces so short that none exceeds the bound
        pieces = min(max(1, int(abs(step) / 0.1)), 200)
        for _ in range(pieces):
            value += step / pieces * (1 - value * value * (1.0 if value * step > 0 else 0.0))
            value = min(max(value, -1.0), 1.0)
        out[moment] = value
    return out


@dataclass(frozen=True)
class HiddenInertia(HiddenEffect):
    """The tool's mass resists accelerations, and the arm vibrates in response to the commanded ones.

    F = -mass R^T y, y'' + 2 zeta w y' + w² y = w² a, a the acceleration of the commanded tool centre.

    Parameters
    ----------
    mass : kg
        Mass beyond the force sensor.
    frequency : Hz
        Frequency w / (2 pi) of the vibration, with zeta = 0.08.
    """

    NUMBER: ClassVar[str] = "29"
    ACTS: ClassVar[str] = "load"
    SOURCE: ClassVar[str] = "Newton; one mode of the arm"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"mass": 0.3},
        "medium": {"mass": 0.6},
        "strong": {"mass": 1.2},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"mass": (0.0, 5.0), "frequency": (2.0, 100.0)}
    mass: float = 0.0
    frequency: float = 18.0

    def load(self, moments: Times, played_log: PlayedLog, scenario: Scenario) -> RealArray | None:
        """Return the load (n, 6), N and N m, sensor frame, that the tool's inertia puts on the force sensor.

        The force is minus the mass times the acceleration of the arm, filtered by the arm's vibration, at the tool's
        centre of gravity. The tool's turning adds no torque of its own.

        Parameters
        ----------
        moments : (n,), ns
            Sorted moments of the host clock.
        played_log : PlayedLog
            Motion of the arm.
        scenario : Scenario
            Mounting of the sensors, centre of gravity of the tool.
        """
        # acceleration of the arm, vibration included
        grid = _grid(played_log, SHAKE_RATE)
        places = played_log.tcp(grid)[:, :3, 3]
        acceleration = np.zeros_like(places)
        acceleration[1:-1] = np.diff(places, 2, axis=0) * SHAKE_RATE**2
        shaken = second_order(acceleration, self.frequency, 0.08, SHAKE_RATE)
        ticks = grid - grid[0]
        at = np.stack([np.interp(moments - grid[0], ticks, column) for column in shaken.T], axis=1)
        # in the frame of the turning tool, at its centre of gravity
        turned = np.einsum("nji,nj->ni", played_log.tcp(moments)[:, :3, :3], at)
        push = -self.mass * turned
        cog = np.asarray(scenario.robot.centre_of_gravity)
        wrench = np.concatenate([push, np.cross(cog, push)], axis=1)
        return move_wrench(wrench, scenario.robot.tcp_from_ft.inverse().matrix)


def second_order(values: RealArray, frequency: float, damping: float, rate: float) -> RealArray:
    """Return values (n, k), filtered by w² / (s² + 2 zeta w s + w²) and at rest in the first of them.

    Parameters
    ----------
    values : (n, k)
        Evenly sampled values.
    frequency : Hz
        Corner frequency w / (2 pi).
    damping : float
        Damping ratio zeta.
    rate : Hz
        Rate of the samples.
    """
    w = 2 * np.pi * frequency
    top, bottom, _ = cont2discrete(([w * w], [1.0, 2 * damping * w, w * w]), 1 / rate, method="foh")
    top, bottom = np.ravel(top), np.ravel(bottom)
    answer: RealArray = lfilter(top, bottom, values - values[:1], axis=0) + values[:1]
    return answer


def _grid(played_log: PlayedLog, rate: float) -> Times:
    """Return evenly spaced moments, ns of the host clock, at a rate in Hz, over a whole log."""
    count = int((played_log.end_ns - played_log.start_ns) * 1e-9 * rate) + 2
    return played_log.start_ns + np.rint(np.arange(count) * 1e9 / rate).astype(np.int64)
