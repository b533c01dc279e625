"""The interface of hidden effects: one method for each place at which an effect may change a recording."""

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
"""Number of the random streams of hidden effects."""


@dataclass(frozen=True)
class EarlierTouch:
    """An earlier touch of the same gel in the same log.

    Parameters
    ----------
    position : (2,), m
        Place on the gel.
    seconds : float
        Time from the log's start to that touch.
    work : J
        Largest elastic work that the touch put into the gel.
    """

    position: tuple[float, float]
    seconds: float
    work: float


@dataclass(frozen=True)
class TouchFacts:
    """The facts about the touch that is played, beside its setup.

    Parameters
    ----------
    touch : TouchPlan
        What the arm was commanded to do.
    scenario : Scenario
        The world that is recorded.
    seconds : float
        Time from the log's start to the touch's start.
    mount : int
        Number of times that indenters have been mounted in this log, this one included.
    log_index : int
        Place of the log in the scenario.
    mounted : Transform
        Pose base_from_indenter, as the log states it.
    earlier_touches : list of EarlierTouch
        Earlier touches of this gel in this log; the list grows as they are played.
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
        """Time in seconds from power-on of the sensor to the touch's start."""
        return self.seconds + self.scenario.recordings.powered


@dataclass(frozen=True)
class RealTouch:
    """A touch at the indenter's real positions, at ``CONTACT_RATE``: the input of effects on forces.

    Parameters
    ----------
    facts : TouchFacts
        Time, mounting and earlier touches.
    setup : TouchSetup
        The touch as it really is.
    law : ContactLaw
        Closed forms for this indenter, place and gel; also in worlds whose contact is the layer solver's.
    path : Path
        The commanded path.
    positions : (n, 3), m
        Real positions of the indenter: x, y, depth.
    """

    facts: TouchFacts
    setup: TouchSetup
    law: ContactLaw
    path: Path
    positions: RealArray

    @property
    def times(self) -> RealArray:
        """Times (n,) of the positions, s from the touch's start."""
        return np.arange(len(self.positions)) / CONTACT_RATE

    @property
    def depth(self) -> RealArray:
        """Depth (n,) of the indenter's lowest point, m; 0 in air."""
        return np.maximum(self.positions[:, 2], 0.0)

    @property
    def radius(self) -> RealArray:
        """Radius (n,), m, of the round contact of equal area; 0 without contact."""
        return np.where(self.depth > 0, np.interp(self.depth, self.law.depth, self.law.radius), 0.0)


class Slide(NamedTuple):
    """The state of sliding of a contact at one moment.

    Parameters
    ----------
    speed : m/s
        Speed of sliding.
    pressure : Pa
        Mean pressure.
    age : s
        Age of the contact in the ageing law of friction.
    direction : rad
        Direction of the pull over the gel, from x.
    """

    speed: float
    pressure: float
    age: float
    direction: float


FrictionFactor = Callable[[Slide], float]
"""Function that gives the factor on Coulomb's limit in a state of sliding."""


class HiddenEffect:
    """Base class of hidden effects.

    A subclass is a frozen dataclass of its parameters, whose defaults are those of no effect. It overrides the methods
    of the places where it acts; every method of this class leaves the recording unchanged.
    """

    NUMBER: ClassVar[str]
    """Number of its row in the catalogue of missing physics; ``outside`` where the catalogue has none."""
    ACTS: ClassVar[str]
    """Place where it acts: ``pose``, ``contact``, ``force``, ``load``, ``sensor`` or ``clock``."""
    SOURCE: ClassVar[str]
    """Publication, or the assumption, that its formula is from."""
    STRENGTHS: ClassVar[Mapping[str, Parameters]]
    """Parameters of the strengths ``weak``, ``medium`` and ``strong``; SI units."""
    RANGES: ClassVar[Mapping[str, tuple[float, float]]]
    """Least and largest allowed value of each parameter."""
    STIFFENS: ClassVar[bool] = False
    """Whether its factor on the normal force also multiplies the tangential stiffness."""
    PER_LOG: ClassVar[bool] = True
    """Whether its random draws for the sensor differ from log to log."""

    def prepared(self, setup: TouchSetup, facts: TouchFacts) -> TouchSetup:
        """Return the touch with its real geometry and offsets."""
        return setup

    def shift(self, path: Path, setup: TouchSetup, facts: TouchFacts) -> RealArray | None:
        """Return the deviation from the path (n, 3), m, at ``CONTACT_RATE``, x, y, depth; None for none.

        Parameters
        ----------
        path : Path
            The commanded path.
        setup : TouchSetup
            The touch as it really is.
        facts : TouchFacts
            Time, mounting and earlier touches.
        """
        return None

    def compliance(self, path: Path, setup: TouchSetup, facts: TouchFacts) -> RealArray | None:
        """Return the compliance (3, 3), m/N, gel frame, of the indenter over the gel; None for none.

        Parameters
        ----------
        path : Path
            The commanded path.
        setup : TouchSetup
            The touch as it really is.
        facts : TouchFacts
            Time, mounting and earlier touches.
        """
        return None

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the normal force (n,), N, from that without the effect."""
        return force

    def tangential_stiffness(self, stiffness: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the tangential stiffness (n,), N/m, from that without the effect."""
        return stiffness

    def friction(self, real_touch: RealTouch) -> FrictionFactor | None:
        """Return the factor on Coulomb's limit as a function of the state of sliding; None for none."""
        return None

    def spread(self) -> float:
        """Return the relative spread of the limits of parts of the contact: 0 for one slider."""
        return 0.0

    def memory(self, real_touch: RealTouch) -> RealArray | None:
        """Return the share (n,) of a tangential pull that is left k samples later, 1 at k = 0; None for no decay."""
        return None

    def load(self, moments: Times, played_log: PlayedLog, scenario: Scenario) -> RealArray | None:
        """Return a further load (n, 6), N and N m, on the force sensor, in its frame; None for none.

        Parameters
        ----------
        moments : (n,), ns
            Sorted moments of the host clock.
        played_log : PlayedLog
            Motion of the arm.
        scenario : Scenario
            Mounting of the sensors, mass of the tool.
        """
        return None

    def sensed(self, values: RealArray, seconds: RealArray, rng: np.random.Generator) -> RealArray:
        """Return the loads (n, 6) that the sensor measures, before its zero is set.

        Parameters
        ----------
        values : (n, 6), N, N m
            Loads on the sensor, in its frame.
        seconds : (n,)
            Sorted times since the log's start.
        rng : Generator
            Random numbers of this effect, and of this log where ``PER_LOG`` holds.
        """
        return values

    def delayed(self, values: RealArray, rate: float) -> RealArray | None:
        """Return loads (n, 6), sampled evenly at a rate in Hz, as a slow sensor shows them; None for no delay."""
        return None

    def reported(self, reading: RealArray) -> RealArray:
        """Return the numbers (n, 6), N and N m, that the sensor sends for a reading, its zero subtracted."""
        return reading

    def stamped(self, stream: str, stamps: Times, seconds: RealArray) -> Times:
        """Return the time stamps (n,), ns, of a stream, from those without the effect.

        Parameters
        ----------
        stream : str
            Name of the stream.
        stamps : (n,), ns
            Stamps without the effect.
        seconds : (n,)
            Times of the samples since the log's start.
        """
        return stamps


def touch_random(facts: TouchFacts, purpose: str) -> np.random.Generator:
    """Return the random numbers of a scenario for one purpose, the same in every log."""
    return np.random.default_rng([facts.scenario.seed, HIDDEN, int.from_bytes(purpose.encode()[:64], "big")])
