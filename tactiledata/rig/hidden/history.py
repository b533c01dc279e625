"""Hidden changes of the gel over time: softening by work, wear, warming up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from tactiledata.arrays import RealArray
from tactiledata.rig.contact.contact import TouchSetup
from tactiledata.rig.hidden.base import HiddenEffect, Parameters, RealTouch, TouchFacts

SPOT = 1.5e-3
"""Standard deviation, m, of the Gaussian weight of an earlier touch at another place."""
RECOVERY = 7200.0
"""Time, s, in which softening by work heals by a factor e."""
FAST, SLOW, FAST_SHARE = 240.0, 1500.0, 0.35
"""Time constants, s, of chip and housing, and the share of the warming by the first."""
EXPANSION = 3e-4
"""Coefficient of thermal expansion of silicone, 1/K."""


def elastic_work(real_touch: RealTouch) -> RealArray:
    """Return the elastic work (n,), J, that the gel holds at each depth on its first loading."""
    table = real_touch.law.depth
    work = np.concatenate(
        [[0.0], np.cumsum((real_touch.law.force[1:] + real_touch.law.force[:-1]) / 2 * np.diff(table))]
    )
    return np.interp(real_touch.depth, table, work)


def _nearness(position: tuple[float, float], other: tuple[float, float]) -> float:
    """Return the weight, 0 to 1, of an earlier touch at one position, m, for another position, m."""
    square = (position[0] - other[0]) ** 2 + (position[1] - other[1]) ** 2
    return float(np.exp(-square / (2 * SPOT**2)))


@dataclass(frozen=True)
class HiddenWorkSoftening(HiddenEffect):
    """The gel is softer, at any speed, below the largest work W_m that its place has ever held.

    F = F0 [1 - s x / (x + 0.3)], x = 1 - W / W_m. Earlier touches count by nearness, and their effect heals slowly.

    Parameters
    ----------
    loss : float
        The factor s; at nearly no work the force is lower by 77 % of s.
    """

    NUMBER: ClassVar[str] = "2"
    ACTS: ClassVar[str] = "force"
    SOURCE: ClassVar[str] = "rational form of our own for the pseudo-elastic softening that L. Mullins described (1948)"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"loss": 0.04},
        "medium": {"loss": 0.12},
        "strong": {"loss": 0.30},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"loss": (0.0, 0.9)}
    STIFFENS: ClassVar[bool] = True
    loss: float = 0.0

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the normal force (n,), N, with softening by the largest earlier work."""
        work, facts = elastic_work(real_touch), real_touch.facts
        before = max(
            (
                earlier.work
                * _nearness(earlier.position, facts.touch.position)
                * np.exp(-(facts.seconds - earlier.seconds) / RECOVERY)
                for earlier in facts.earlier_touches
            ),
            default=0.0,
        )
        most = np.maximum(np.maximum.accumulate(work), before)
        left = 1 - np.divide(work, most, out=np.ones_like(work), where=most > 0)
        return force * (1 - self.loss * left / (left + 0.3))


@dataclass(frozen=True)
class HiddenWear(HiddenEffect):
    """A worn place is softer: F = F0 [1 - loss n / (n + 10)], n the earlier touches of this log, by nearness.

    Parameters
    ----------
    loss : float
        Relative loss of force after very many touches.
    """

    NUMBER: ClassVar[str] = "22"
    ACTS: ClassVar[str] = "force"
    SOURCE: ClassVar[str] = "hyperbolic saturation, assumed"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"loss": 0.05},
        "medium": {"loss": 0.12},
        "strong": {"loss": 0.25},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"loss": (0.0, 0.9)}
    STIFFENS: ClassVar[bool] = True
    loss: float = 0.0

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the normal force (n,), N, of the worn place."""
        count = sum(
            _nearness(earlier.position, real_touch.facts.touch.position) for earlier in real_touch.facts.earlier_touches
        )
        return force * (1 - self.loss * count / (count + 10))


def warmth(seconds_on: float, rise: float) -> float:
    """Return the warming, K, since power-on of a sensor that in the end gets ``rise`` K warmer."""
    left = FAST_SHARE * np.exp(-seconds_on / FAST) + (1 - FAST_SHARE) * np.exp(-seconds_on / SLOW)
    return float(rise * (1 - left))


@dataclass(frozen=True)
class HiddenWarmUp(HiddenEffect):
    """The sensor warms up after power-on, with two time constants (4 and 25 min): the gel softens and grows.

    F = F0 (1 - softening T), and its surface rises by 3e-4 /K h T, with T the warming and h the thickness.

    Parameters
    ----------
    rise : K
        Final warming.
    softening : 1/K
        Relative loss of stiffness per kelvin.
    """

    NUMBER: ClassVar[str] = "21"
    ACTS: ClassVar[str] = "force"
    SOURCE: ClassVar[str] = "two lumped heat capacities; expansion of silicone rubber"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"rise": 5.0},
        "medium": {"rise": 12.0},
        "strong": {"rise": 25.0},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"rise": (0.0, 60.0), "softening": (-0.01, 0.01)}
    STIFFENS: ClassVar[bool] = True
    rise: float = 0.0
    softening: float = 0.006

    def prepared(self, setup: TouchSetup, facts: TouchFacts) -> TouchSetup:
        """Return the touch on the gel that has grown."""
        growth = EXPANSION * setup.thickness * warmth(facts.seconds_on, self.rise)
        return replace(setup, offset=setup.offset + np.array([0.0, 0.0, growth]))

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the normal force (n,), N, of the gel that has softened."""
        return force * (1 - self.softening * warmth(real_touch.facts.seconds_on, self.rise))
