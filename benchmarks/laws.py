"""Laws by which physics may be left out, in formulas that neither the rig nor the catalogue of effects has.

A diagnosis that knows an effect by one formula should name it where nature has another one. Each law says which effect
of the catalogue it is, or that it is none of them, and in which range its strength is drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tactiledata.arrays import RealArray, Times
from tactiledata.rig.contact.contact import CONTACT_RATE, TouchSetup
from tactiledata.rig.hidden.base import FrictionFactor, HiddenEffect, Parameters, RealTouch, TouchFacts
from tactiledata.rig.hidden.sensor import ARM
from tactiledata.rig.hidden.time import relaxed
from tactiledata.rig.motion.motion import Path


@dataclass(frozen=True)
class Law(HiddenEffect):
    """A hidden effect of one strength.

    Parameters
    ----------
    strength : float
        Its size; 0 is none.
    """

    NUMBER: ClassVar[str] = "outside"
    SOURCE: ClassVar[str] = "assumed"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {}
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {}
    EFFECT: ClassVar[str] = ""
    """Name in the catalogue; empty where the catalogue does not have it."""
    DRAWN: ClassVar[tuple[float, float]]
    """Range in which the logarithm of the strength is drawn evenly."""
    strength: float = 0.0


class StretchedRelaxation(Law):
    """Changes of force decay by a share as exp(-sqrt(t / 2 s)), Kohlrausch's stretched exponential."""

    ACTS, EFFECT, DRAWN = "force", "relaxation", (0.02, 0.3)

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the relaxed normal force (n,), N, at or above 0."""
        return np.where(force > 0, np.maximum(relaxed(force, self._kernel), 0.0), force)

    def memory(self, real_touch: RealTouch) -> RealArray:
        """Return the share (n,) of a tangential pull that is left k samples later."""
        return self._kernel(np.arange(len(real_touch.positions)) / CONTACT_RATE)

    def _kernel(self, seconds: RealArray) -> RealArray:
        """Return the relaxation function (n,) at seconds (n,)."""
        left: RealArray = 1.0 - self.strength * (1.0 - np.exp(-np.sqrt(seconds / 2.0)))
        return left


class SaturatingRateFriction(Law):
    """Friction rises with the speed v by a share v / (v + 1 mm/s)."""

    ACTS, EFFECT, DRAWN = "force", "rate_friction", (0.03, 0.6)

    def friction(self, real_touch: RealTouch) -> FrictionFactor:
        """Return the factor on Coulomb's limit at a speed."""
        return lambda slide: 1.0 + self.strength * slide.speed / (slide.speed + 1e-3)


class PowerOfPressureFriction(Law):
    """Friction falls with the mean pressure p as (p / 0.1 MPa)^-n."""

    ACTS, EFFECT, DRAWN = "force", "area_friction", (0.03, 0.33)

    def friction(self, real_touch: RealTouch) -> FrictionFactor:
        """Return the factor on Coulomb's limit at a pressure."""
        return lambda slide: (max(slide.pressure, 1e3) / 1e5) ** -self.strength


class FadingAgeFriction(Law):
    """Friction rises with the age of the contact by a share 1 - exp(-age / 1 s)."""

    ACTS, EFFECT, DRAWN = "force", "static_friction", (0.05, 0.6)

    def friction(self, real_touch: RealTouch) -> FrictionFactor:
        """Return the factor on Coulomb's limit at an age."""
        return lambda slide: 1.0 + self.strength * -float(np.expm1(-slide.age))


class WarmingFriction(Law):
    """Friction rises while the sensor warms up: by a share 1 - exp(-t / 300 s). The catalogue does not have it."""

    ACTS, DRAWN = "force", (0.05, 0.5)

    def friction(self, real_touch: RealTouch) -> FrictionFactor:
        """Return the factor on Coulomb's limit in this touch."""
        factor = 1.0 - self.strength * float(np.expm1(-real_touch.facts.seconds / 300.0))
        return lambda slide: factor


class MovingMeanLag(Law):
    """The sensor shows the mean of the last moments, s."""

    ACTS, EFFECT, DRAWN = "sensor", "lag", (0.01, 0.2)

    def delayed(self, values: RealArray, rate: float) -> RealArray:
        """Return evenly sampled loads (n, 6), averaged over what came before."""
        width = max(1, round(self.strength * rate))
        sums = np.cumsum(np.concatenate([np.repeat(values[:1], width, axis=0), values]), axis=0)
        return (sums[width:] - sums[:-width]) / width


class WarmingClock(Law):
    """The force sensor's clock runs fast until it is warm: stamps are ahead by a time (1 - exp(-t / 200 s)), s."""

    ACTS, EFFECT, DRAWN = "clock", "clock_skew", (0.005, 0.08)

    def stamped(self, stream: str, stamps: Times, seconds: RealArray) -> Times:
        """Return the stamps (n,), ns, of the force sensor."""
        if stream != "wrench":
            return stamps
        ahead: Times = np.rint(-self.strength * np.expm1(-seconds / 200.0) * 1e9).astype(np.int64)
        return stamps + ahead


class SwingingZero(Law):
    """The sensor's zero swings with a room's temperature, N, with a period of 240 s."""

    ACTS, EFFECT, DRAWN = "sensor", "sensor_drift", (0.05, 1.0)

    def sensed(self, values: RealArray, seconds: RealArray, rng: np.random.Generator) -> RealArray:
        """Return loads (n, 6), N and N m, with the swinging zero."""
        way = rng.normal(size=6)
        way /= np.linalg.norm(way[:3])
        swing = self.strength * np.sin(2 * np.pi * seconds / 240.0 + rng.uniform(0, 2 * np.pi))
        return values + swing[:, None] * way * np.array([1.0, 1.0, 1.0, ARM, ARM, ARM])


class OneAxisGain(Law):
    """One axis of force reads too much, and another one a third as much of it."""

    ACTS, EFFECT, DRAWN = "sensor", "gain_crosstalk", (0.01, 0.15)
    PER_LOG = False

    def sensed(self, values: RealArray, seconds: RealArray, rng: np.random.Generator) -> RealArray:
        """Return loads (n, 6), N and N m, of a sensor with a wrong gain."""
        first, second = rng.permutation(3)[:2]
        out = values.copy()
        out[:, first] += self.strength * values[:, first]
        out[:, second] += self.strength / 3.0 * values[:, first]
        return out


class Hysteresis(Law):
    """The sensor's reading follows a force only beyond a half width, N (a play). The catalogue does not have it."""

    ACTS, DRAWN = "sensor", (0.05, 0.8)

    def sensed(self, values: RealArray, seconds: RealArray, rng: np.random.Generator) -> RealArray:
        """Return loads (n, 6), N and N m, behind the play."""
        width = self.strength * np.array([1.0, 1.0, 1.0, ARM, ARM, ARM])
        out = np.empty_like(values)
        held = values[0]
        for row, load in enumerate(values):
            held = np.clip(held, load - width, load + width)
            out[row] = held
        return out


class Knee(Law):
    """Each axis of force shows a third of what lies beyond the reciprocal of the strength, N."""

    ACTS, EFFECT, DRAWN = "sensor", "clipping", (0.1, 0.4)

    def reported(self, reading: RealArray) -> RealArray:
        """Return the reading (n, 6), N and N m, with a knee."""
        limit = 1.0 / self.strength if self.strength else np.inf
        out = reading.copy()
        beyond = np.maximum(np.abs(reading[:, :3]) - limit, 0.0)
        out[:, :3] -= np.sign(reading[:, :3]) * beyond * (2.0 / 3.0)
        return out


class SoftMount(Law):
    """Whatever holds the tool gives way alike in all directions, m/N."""

    ACTS, EFFECT, DRAWN = "pose", "arm_compliance", (4e-6, 6e-5)

    def compliance(self, path: Path, setup: TouchSetup, facts: TouchFacts) -> RealArray:
        """Return the compliance (3, 3), m/N."""
        return self.strength * np.eye(3)


class PullOfEdge(Law):
    """The contact pulls in proportion to its radius, N/m, as long as it lasts."""

    ACTS, EFFECT, DRAWN = "force", "adhesion", (10.0, 400.0)

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the normal force (n,), N, less the pull."""
        return force - self.strength * real_touch.radius


class UnloadingLoss(Law):
    """A gel that has been pressed deeper is softer by a share of what is missing to that depth, within a touch."""

    ACTS, EFFECT, DRAWN = "force", "mullins", (0.02, 0.4)

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the normal force (n,), N."""
        deepest = np.maximum.accumulate(real_touch.depth)
        missing = 1.0 - np.divide(real_touch.depth, deepest, out=np.ones_like(deepest), where=deepest > 0)
        return force * (1.0 - self.strength * missing)


class SlowWarmth(Law):
    """The gel softens with the root of the time since power-on, by a share in 600 s."""

    ACTS, EFFECT, DRAWN = "force", "heating", (0.02, 0.4)
    STIFFENS = True

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the normal force (n,), N."""
        seconds = real_touch.facts.seconds_on + real_touch.times
        return force * (1.0 - self.strength * np.sqrt(np.minimum(seconds / 600.0, 4.0)))


class SoftCone(Law):
    """The gel is softer about a place, by a share that falls evenly to nothing within 3 mm."""

    ACTS, EFFECT, DRAWN = "force", "soft_region", (0.05, 0.6)
    STIFFENS = True

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the normal force (n,), N."""
        away = np.linalg.norm(real_touch.positions[:, :2] - np.array([-1.5e-3, 1e-3]), axis=1)
        return force * (1.0 - self.strength * np.maximum(1.0 - away / 3e-3, 0.0))


class ExponentialStiffening(Law):
    """The force rises by exp(k d / h) at a depth d of a gel of thickness h, as Fung's tissues do."""

    ACTS, EFFECT, DRAWN = "force", "strain_stiffening", (0.1, 3.0)
    STIFFENS = True

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the normal force (n,), N."""
        return force * np.exp(self.strength * real_touch.depth / real_touch.setup.thickness)


LAWS: tuple[type[Law], ...] = (
    StretchedRelaxation,
    SaturatingRateFriction,
    PowerOfPressureFriction,
    FadingAgeFriction,
    MovingMeanLag,
    WarmingClock,
    SwingingZero,
    OneAxisGain,
    Knee,
    SoftMount,
    PullOfEdge,
    UnloadingLoss,
    SlowWarmth,
    SoftCone,
    ExponentialStiffening,
    WarmingFriction,
    Hysteresis,
)
