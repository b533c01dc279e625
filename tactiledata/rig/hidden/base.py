"""What an effect that only the rig knows may do to a recording: one method for each place where it can act."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from tactiledata.arrays import RealArray, Times
from tactiledata.rig.contact.closed_form import ContactLaw
from tactiledata.rig.contact.contact import CONTACT_RATE, TouchSetup
from tactiledata.rig.motion.motion import Path
from tactiledata.rig.motion.touch import TouchPlan
from tactiledata.rig.scenario.scenario import Scenario
from tactiledata.transforms import Transform

if TYPE_CHECKING:
    from tactiledata.rig.play import PlayedLog

Parameters = Mapping[str, float]

HIDDEN = 11
"""Number of the random streams."""


@dataclass(frozen=True)
class EarlierTouch:
    """An earlier touch of the same gel.

    Parameters
    ----------
    position : (2,), m
    seconds : float
        Since the log's start.
    work : J
        Greatest elastic work that it put into the gel.
    """

    position: tuple[float, float]
    seconds: float
    work: float


@dataclass(frozen=True)
class TouchFacts:
    """All that an effect may ask about the touch that is played.

    Parameters
    ----------
    touch : TouchPlan
    scenario : Scenario
    seconds : float
        From the log's start to the touch's.
    mount : int
        How often indenters have been mounted in this log before.
    log_index : int
    mounted : Transform
        base_from_indenter, as the log states it.
    earlier_touches : list of EarlierTouch
        Earlier touches of this gel in this log; it grows as they are played.
    """

    touch: TouchPlan
    scenario: Scenario
    seconds: float
    mount: int
    log_index: int
    mounted: Transform
    earlier_touches: list[EarlierTouch]

    @property
    def seconds_on(self) -> float:
        """Since the sensor was switched on."""
        return self.seconds + self.scenario.recordings.powered


@dataclass(frozen=True)
class RealTouch:
    """A touch as the gel feels it before an effect, at ``CONTACT_RATE``.

    Parameters
    ----------
    facts : TouchFacts
    setup : TouchSetup
    law : ContactLaw
        Closed forms for this indenter, place and gel; also in worlds whose contact is the layer solver's.
    path : Path
    positions : (n, 3), m
        Where the indenter really is: x, y, depth.
    """

    facts: TouchFacts
    setup: TouchSetup
    law: ContactLaw
    path: Path
    positions: RealArray

    @property
    def times(self) -> RealArray:
        """Seconds (n,) from the touch's start."""
        return np.arange(len(self.positions)) / CONTACT_RATE

    @property
    def depth(self) -> RealArray:
        """Metres (n,), at least 0."""
        return np.maximum(self.positions[:, 2], 0.0)

    @property
    def radius(self) -> RealArray:
        """Radius (n,), m, of the round contact of equal area; 0 without contact."""
        return np.where(self.depth > 0, np.interp(self.depth, self.law.depth, self.law.radius), 0.0)


class Slide(NamedTuple):
    """How a contact slides at one moment: speed m/s, pressure Pa, age s, direction of the pull rad, gel frame."""

    speed: float
    pressure: float
    age: float
    direction: float


FrictionFactor = Callable[[Slide], float]


class HiddenEffect:
    """One effect; a subclass is a frozen dataclass of its parameters, whose defaults are the null, and overrides the
    places where it acts.
    """

    NUMBER: ClassVar[str]
    """Of the row in the catalogue of missing physics that it stands for; ``outside`` where the catalogue has none."""
    ACTS: ClassVar[str]
    """``pose``, ``contact``, ``force``, ``load``, ``sensor`` or ``clock``."""
    SOURCE: ClassVar[str]
    STRENGTHS: ClassVar[Mapping[str, Parameters]]
    """Parameters of ``weak``, ``medium`` and ``strong``; SI units."""
    RANGES: ClassVar[Mapping[str, tuple[float, float]]]
    """Least and greatest value of each parameter."""
    STIFFENS: ClassVar[bool] = False
    """Whether what multiplies the normal force multiplies the tangential stiffness too."""
    PER_LOG: ClassVar[bool] = True
    """Whether what it draws for the sensor differs from log to log."""

    def prepared(self, setup: TouchSetup, facts: TouchFacts) -> TouchSetup:
        """The touch as it really is: geometry and offsets."""
        return setup

    def shift(self, path: Path, setup: TouchSetup, facts: TouchFacts) -> RealArray | None:
        """What the path really misses (n, 3) at ``CONTACT_RATE``: x, y, depth, m."""
        return None

    def compliance(self, path: Path, setup: TouchSetup, facts: TouchFacts) -> RealArray | None:
        """Move (3, 3), m/N, of the indenter over the gel by the force on it: gel frame."""
        return None

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Normal force (n,), N, from that without the effect."""
        return force

    def tangential_stiffness(self, stiffness: RealArray, real_touch: RealTouch) -> RealArray:
        """Stiffness (n,), N/m, from that without the effect."""
        return stiffness

    def friction(self, real_touch: RealTouch) -> FrictionFactor | None:
        """What multiplies the limit of friction."""
        return None

    def spread(self) -> float:
        """Spread of the limits of parts of the contact, relative: 0 for one slider."""
        return 0.0

    def memory(self, real_touch: RealTouch) -> RealArray | None:
        """Share (n,) of a tangential pull that the gel still holds after so many samples, 1 at once."""
        return None

    def load(self, moments: Times, played_log: PlayedLog, scenario: Scenario) -> RealArray | None:
        """A further load (n, 6) on the force sensor, in its frame, at sorted moments of the host clock."""
        return None

    def sensed(self, values: RealArray, seconds: RealArray, rng: np.random.Generator) -> RealArray:
        """What the sensor makes of loads (n, 6) at sorted seconds (n,) since the log's start, before it is tared."""
        return values

    def delayed(self, values: RealArray, rate: float) -> RealArray | None:
        """What a slow sensor shows of evenly sampled loads (n, 6); None where it is not slow."""
        return None

    def reported(self, reading: RealArray) -> RealArray:
        """The numbers (n, 6) that leave the sensor."""
        return reading

    def stamped(self, stream: str, stamps: Times, seconds: RealArray) -> Times:
        """Stamps (n,) of a stream, ns, from those without the effect; seconds (n,) since the log's start."""
        return stamps


def touch_random(facts: TouchFacts, purpose: str) -> np.random.Generator:
    """Random numbers of a scenario for one purpose, the same in every log."""
    return np.random.default_rng([facts.scenario.seed, HIDDEN, int.from_bytes(purpose.encode()[:64], "big")])
