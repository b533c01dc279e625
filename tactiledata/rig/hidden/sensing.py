"""The hidden effects on a log's force readings and time stamps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.arrays import RealArray, Times
from tactiledata.rig.contact.contact import CONTACT_RATE
from tactiledata.rig.hidden.base import HIDDEN, HiddenEffect
from tactiledata.rig.scenario.scenario import Scenario

if TYPE_CHECKING:
    from tactiledata.rig.play import PlayedLog

Loads = Callable[[Times], RealArray]
"""Function that gives loads (n, 6), N and N m, at moments (n,) of the host clock."""


def hidden_loads(scenario: Scenario, played_log: PlayedLog, moments: Times) -> RealArray:
    """Return the load (n, 6), N and N m, that hidden effects add on the force sensor, in its frame.

    Parameters
    ----------
    scenario : Scenario
        Its hidden effects count.
    played_log : PlayedLog
        Motion of the arm.
    moments : (n,), ns
        Sorted moments of the host clock.
    """
    out = np.zeros((len(moments), 6))
    for effect in scenario.hidden:
        load = effect.load(moments, played_log, scenario)
        if load is not None:
            out += load
    return out


def sensed_loads(scenario: Scenario, played_log: PlayedLog, index: int, loads: Loads, moments: Times) -> RealArray:
    """Return the loads (n, 6), N and N m, that the force sensor measures, before its zero is set.

    A slow sensor's filter runs over evenly sampled loads of the whole log.

    Parameters
    ----------
    scenario : Scenario
        Its hidden effects count.
    played_log : PlayedLog
        Start and end of the log.
    index : int
        Place of the log in the scenario; seeds the draws.
    loads : callable
        Gives the loads on the sensor at moments.
    moments : (n,), ns
        Sorted moments of the host clock.
    """
    start = played_log.start_ns
    slow = [effect for effect in scenario.hidden if effect.delayed(np.zeros((2, 6)), CONTACT_RATE) is not None]
    if not slow:
        return _sensed(scenario, index, loads(moments), (moments - start) * 1e-9)
    count = int((played_log.end_ns - start) * 1e-9 * CONTACT_RATE) + 2
    seconds = np.arange(count) / CONTACT_RATE
    values = _sensed(scenario, index, loads(start + np.rint(seconds * 1e9).astype(np.int64)), seconds)
    for effect in slow:
        late = effect.delayed(values, CONTACT_RATE)
        values = values if late is None else late
    at = (moments - start) * 1e-9
    return np.stack([np.interp(at, seconds, column) for column in values.T], axis=1)


def _sensed(scenario: Scenario, index: int, values: RealArray, seconds: RealArray) -> RealArray:
    """Return loads (n, 6) changed by every effect on the sensor but slowness, at seconds (n,) since the log's start."""
    for effect in scenario.hidden:
        # the class name without its prefix: its bytes seed the draws, and recordings stay the same bit for bit
        stream = int.from_bytes(type(effect).__name__.removeprefix("Hidden").encode(), "big")
        seed = [scenario.seed, HIDDEN, stream, *([index] if effect.PER_LOG else [])]
        values = effect.sensed(values, seconds, np.random.default_rng(seed))
    return values


def reported_readings(effects: Sequence[HiddenEffect], reading: RealArray) -> RealArray:
    """Return the numbers (n, 6), N and N m, that the sensor sends for a reading, its zero subtracted."""
    for effect in effects:
        reading = effect.reported(reading)
    return reading


def reported_stamps(effects: Sequence[HiddenEffect], stream: str, stamps: Times, seconds: RealArray) -> Times:
    """Return the time stamps (n,), ns, of a stream, changed by hidden effects.

    Parameters
    ----------
    effects : sequence of HiddenEffect
        Effects, in the order in which they act.
    stream : str
        Name of the stream.
    stamps : (n,), ns
        Stamps without effects.
    seconds : (n,)
        Times of the samples since the log's start.
    """
    for effect in effects:
        stamps = effect.stamped(stream, stamps, seconds)
    return stamps
