"""Hidden faults of the force sensor: its zero, gains, frame, delay, dead band and range."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.spatial.transform import Rotation

from tactiledata.arrays import RealArray
from tactiledata.rig.hidden.base import HiddenEffect, Parameters
from tactiledata.rig.hidden.load import second_order

ARM = 0.02
"""Ratio of torques to forces, m, in zeros, bands and quanta."""
GAIN_ARM = 0.05
"""Ratio of torques to forces, m, in gains."""
FULL_SCALE = 15.0
"""Force, N, at which the quadratic part of the gain has its stated size."""


@dataclass(frozen=True)
class HiddenWanderingZero(HiddenEffect):
    """The zero of the sensor drifts: b(t) = size (1 - exp(-t / T)) n + a random walk of each axis.

    The direction n is drawn per log; torques drift by 0.02 m times as much.

    Parameters
    ----------
    size : N
        Final drift without the walk.
    walk : N/sqrt(s)
        Standard deviation of the random walk after 1 s.
    time : s
        Time constant T, from the start of the log.
    """

    NUMBER: ClassVar[str] = "13"
    ACTS: ClassVar[str] = "sensor"
    SOURCE: ClassVar[str] = "one thermal time constant and Brownian motion"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"size": 0.3, "walk": 0.003},
        "medium": {"size": 1.0, "walk": 0.010},
        "strong": {"size": 3.0, "walk": 0.030},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {
        "size": (0.0, 20.0),
        "walk": (0.0, 1.0),
        "time": (1.0, 1e5),
    }
    size: float = 0.0
    walk: float = 0.0
    time: float = 600.0

    def sensed(self, values: RealArray, seconds: RealArray, rng: np.random.Generator) -> RealArray:
        """Return loads (n, 6), N and N m, with the drifting zero.

        Parameters
        ----------
        values : (n, 6), N, N m
            Loads on the sensor.
        seconds : (n,)
            Sorted times since the log's start.
        rng : Generator
            Random numbers of this effect and log.
        """
        scale = np.array([1.0, 1.0, 1.0, ARM, ARM, ARM])
        directions = rng.normal(size=(2, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        creep = self.size * (1 - np.exp(-seconds / self.time))[:, None] * directions.ravel()
        # on a fixed grid, so that the walk does not depend on the moments of sampling
        grid = np.arange(int(seconds[-1]) + 2.0)
        steps = rng.normal(0.0, 1.0, (len(grid), 6))
        steps[0] = 0.0
        wander = self.walk * np.cumsum(steps, axis=0)
        walked = np.stack([np.interp(seconds, grid, column) for column in wander.T], axis=1)
        return values + scale * (creep + walked)


@dataclass(frozen=True)
class HiddenCrossTalk(HiddenEffect):
    """The calibration is wrong: w' = (1 + C) w + Q w |F| / 15 N, with C (6, 6) and diagonal Q drawn per scenario.

    Parameters
    ----------
    gain : float
        Size of the diagonal of C; signs are drawn.
    cross : float
        Standard deviation of the rest of C; between forces and torques with an arm of 0.05 m.
    quadratic : float
        Standard deviation of the diagonal of Q.
    """

    NUMBER: ClassVar[str] = "14"
    ACTS: ClassVar[str] = "sensor"
    SOURCE: ClassVar[str] = "affine and quadratic terms of a strain-gauge calibration"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"gain": 0.01, "cross": 0.005, "quadratic": 0.003},
        "medium": {"gain": 0.025, "cross": 0.015, "quadratic": 0.008},
        "strong": {"gain": 0.05, "cross": 0.03, "quadratic": 0.02},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {
        "gain": (-0.5, 0.5),
        "cross": (0.0, 0.3),
        "quadratic": (0.0, 0.3),
    }
    PER_LOG: ClassVar[bool] = False
    gain: float = 0.0
    cross: float = 0.0
    quadratic: float = 0.0

    def sensed(self, values: RealArray, seconds: RealArray, rng: np.random.Generator) -> RealArray:
        """Return loads (n, 6), N and N m, as a wrong calibration gives them.

        Parameters
        ----------
        values : (n, 6), N, N m
            Loads on the sensor.
        seconds : (n,)
            Sorted times since the log's start; without influence.
        rng : Generator
            Random numbers of this effect, the same in every log.
        """
        matrix = self.cross * rng.normal(size=(6, 6))
        matrix[:3, 3:] /= GAIN_ARM
        matrix[3:, :3] *= GAIN_ARM
        np.fill_diagonal(matrix, self.gain * rng.choice([-1.0, 1.0], 6))
        bend = self.quadratic * rng.normal(size=6)
        size = np.linalg.norm(values[:, :3], axis=1, keepdims=True) / FULL_SCALE
        answer: RealArray = values + values @ matrix.T + bend * values * size
        return answer


@dataclass(frozen=True)
class HiddenFrameRotation(HiddenEffect):
    """The sensor's frame is turned against the stated one, by the rotation exp(yaw z + tilt x').

    Parameters
    ----------
    yaw, tilt : rad
        Angles about the sensor's z, and about an axis x' across it at 0.7 rad from x.
    """

    NUMBER: ClassVar[str] = "17"
    ACTS: ClassVar[str] = "sensor"
    SOURCE: ClassVar[str] = "a rotation of SO(3) by its vector"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"yaw": 0.0087, "tilt": 0.0035},
        "medium": {"yaw": 0.0262, "tilt": 0.0087},
        "strong": {"yaw": 0.0524, "tilt": 0.0175},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"yaw": (-1.0, 1.0), "tilt": (-0.5, 0.5)}
    yaw: float = 0.0
    tilt: float = 0.0

    def sensed(self, values: RealArray, seconds: RealArray, rng: np.random.Generator) -> RealArray:
        """Return loads (n, 6), N and N m, in the turned frame.

        Parameters
        ----------
        values : (n, 6), N, N m
            Loads on the sensor, stated frame.
        seconds : (n,)
            Sorted times since the log's start; without influence.
        rng : Generator
            Random numbers; without influence.
        """
        vector = [self.tilt * np.cos(0.7), self.tilt * np.sin(0.7), self.yaw]
        turn = Rotation.from_rotvec(vector).as_matrix()
        return np.concatenate([values[:, :3] @ turn.T, values[:, 3:] @ turn.T], axis=1)


@dataclass(frozen=True)
class HiddenSlowSensor(HiddenEffect):
    """The sensor is late: a pure delay, then a low pass of second order (zeta 0.8).

    In all it is late by ``delay + 1.6 / (2 pi / period)``.

    Parameters
    ----------
    delay : s
        The pure delay.
    period : s
        Reciprocal of the low pass's corner frequency; 0 for no low pass.
    """

    NUMBER: ClassVar[str] = "18"
    ACTS: ClassVar[str] = "sensor"
    SOURCE: ClassVar[str] = "transfer function of second order with dead time"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"delay": 0.004, "period": 0.025},
        "medium": {"delay": 0.010, "period": 0.0625},
        "strong": {"delay": 0.030, "period": 0.125},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"delay": (0.0, 1.0), "period": (0.0, 2.0)}
    delay: float = 0.0
    period: float = 0.0

    def delayed(self, values: RealArray, rate: float) -> RealArray | None:
        """Return evenly sampled loads (n, 6), delayed and filtered; None without effect."""
        if self.delay == 0 and self.period == 0:
            return None
        ticks = np.arange(len(values))
        late = np.stack([np.interp(ticks - self.delay * rate, ticks, column) for column in values.T], axis=1)
        return late if self.period == 0 else second_order(late, 1 / self.period, 0.8, rate)


@dataclass(frozen=True)
class HiddenDeadBand(HiddenEffect):
    """The sensor does not show small forces: each axis below the band reads 0, and the rest has coarse quanta.

    Parameters
    ----------
    band, quantum : N
        Width of the band and size of the quanta; for torques 0.02 m times as much.
    """

    NUMBER: ClassVar[str] = "26"
    ACTS: ClassVar[str] = "sensor"
    SOURCE: ClassVar[str] = "a threshold and a rounding"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"band": 0.1, "quantum": 0.02},
        "medium": {"band": 0.25, "quantum": 0.05},
        "strong": {"band": 0.5, "quantum": 0.1},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"band": (0.0, 5.0), "quantum": (0.0, 2.0)}
    band: float = 0.0
    quantum: float = 0.0

    def reported(self, reading: RealArray) -> RealArray:
        """Return the reading (n, 6), N and N m, with dead band and quanta."""
        scale = np.array([1.0, 1.0, 1.0, ARM, ARM, ARM])
        out = reading
        if self.quantum > 0:
            out = np.round(out / (self.quantum * scale)) * (self.quantum * scale)
        return np.where(np.abs(reading) < self.band * scale, 0.0, out)


@dataclass(frozen=True)
class HiddenSaturation(HiddenEffect):
    """The sensor's range ends softly: each force f reads f / [1 + (|f| / limit)⁸]^(1/8); torques stay.

    Parameters
    ----------
    bound : 1/N
        Reciprocal of the limit, 1 / limit.
    """

    NUMBER: ClassVar[str] = "27"
    ACTS: ClassVar[str] = "sensor"
    SOURCE: ClassVar[str] = "a smooth clipping"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"bound": 1 / 10.0},
        "medium": {"bound": 1 / 7.0},
        "strong": {"bound": 1 / 5.0},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"bound": (0.0, 1.0)}
    bound: float = 0.0

    def reported(self, reading: RealArray) -> RealArray:
        """Return the reading (n, 6), N and N m, with forces that saturate."""
        out = reading.copy()
        out[:, :3] /= (1 + (np.abs(reading[:, :3]) * self.bound) ** 8) ** (1 / 8)
        return out
