"""The errors of a real rig: coloured noise, bias and drift, quanta, repeated samples, clocks, losses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray, Times
from tactiledata.rig.scenario.scenario import ClockSetup, Imperfections

TORQUE_PER_FORCE = 0.02
"""Ratio of torques to forces in bias and drift, m."""


def sampling_times(start_ns: int, end_ns: int, rate: float, jitter: float, rng: np.random.Generator) -> Times:
    """Return the moments of sampling (n,), ns of the host clock: even, with jitter, strictly increasing.

    Parameters
    ----------
    start_ns, end_ns : int
        Half-open interval, ns of the host clock.
    rate : Hz
        Rate of the samples.
    jitter : s
        Standard deviation of each moment, cut at 0.4 periods.
    rng : Generator
        Draws the jitter.
    """
    period = 1e9 / rate
    # relative to the start: a float cannot hold nanoseconds since 1970
    since = np.arange(0.0, end_ns - start_ns, period)
    if jitter:
        since = since + np.clip(rng.normal(0.0, jitter * 1e9, len(since)), -0.4 * period, 0.4 * period)
    return start_ns + np.rint(since).astype(np.int64)


def stream_stamps(host_ns: Times, clock: ClockSetup) -> Times:
    """Return the time (n,), ns, on a stream's own clock at moments of the host clock.

    The clock runs as fast as the host's: host = stream + offset, with one offset for all moments.
    """
    return host_ns - clock.offset_ns


def arrival_times(host_ns: Times, clock: ClockSetup, rng: np.random.Generator) -> Times:
    """Return the moments (n,), ns of the host clock, at which messages are written: a random latency later, in order.

    Parameters
    ----------
    host_ns : (n,), ns
        Moments of sampling, host clock.
    clock : ClockSetup
        Mean latency.
    rng : Generator
        Draws the latencies.
    """
    if not len(host_ns):
        return host_ns
    delay = clock.latency * rng.gamma(4.0, 0.25, len(host_ns)) * 1e9
    return np.maximum.accumulate(host_ns + delay.astype(np.int64))


def coloured_noise(
    count: int, scale: RealArray, rate: float, setup: Imperfections, rng: np.random.Generator
) -> RealArray:
    """Return white noise plus a first-order autoregressive part, (count, k).

    Parameters
    ----------
    count : int
        Number of samples.
    scale : (k,)
        Standard deviations of the white part, which decide the unit.
    rate : Hz
        Rate of the samples.
    setup : Imperfections
        Share and correlation time of the autoregressive part.
    rng : Generator
        Draws the noise.
    """
    from scipy.signal import lfilter  # imported where noise is drawn, which few commands do

    white = rng.standard_normal((count, len(scale)))
    memory = float(np.exp(-1.0 / (rate * setup.correlation_time)))
    drive = rng.standard_normal((count, len(scale))) * np.sqrt(1.0 - memory**2)
    slow = lfilter([1.0], [1.0, -memory], drive, axis=0)
    return scale * (white + setup.coloured_share * slow)


def bias_over_time(seconds: RealArray, setup: Imperfections, rng: np.random.Generator) -> RealArray:
    """Return the bias (n, 6), N and N m, of a force sensor: a constant plus a linear drift.

    Parameters
    ----------
    seconds : (n,)
        Times since the log's start.
    setup : Imperfections
        Standard deviations of bias, N, and drift, N per minute.
    rng : Generator
        Draws both.
    """
    scale = np.array([1.0, 1.0, 1.0, *[TORQUE_PER_FORCE] * 3])
    constant = rng.normal(0.0, setup.force_bias, 6) * scale
    slope = rng.normal(0.0, setup.force_drift, 6) * scale / 60.0
    return constant + seconds[:, None] * slope


def quantised(wrench: RealArray, setup: Imperfections) -> RealArray:
    """Return wrenches (n, 6), N and N m, rounded to the sensor's quanta."""
    rounded = wrench.copy()
    for columns, quantum in ((slice(0, 3), setup.force_quantum), (slice(3, 6), setup.torque_quantum)):
        if quantum > 0:
            rounded[:, columns] = np.round(wrench[:, columns] / quantum) * quantum
    return rounded


def held(values: RealArray, seconds: RealArray, rate: float) -> RealArray:
    """Return values of which new ones come only at a lower rate: in between, the last one is repeated.

    Parameters
    ----------
    values : (n, k)
        Samples.
    seconds : (n,)
        Their times.
    rate : Hz
        Rate of new values; 0 leaves the samples as they are.
    """
    if rate <= 0 or not len(values):
        return values
    tick = np.floor((seconds - seconds[0]) * rate + 1e-9)
    first = np.concatenate([[0], np.flatnonzero(np.diff(tick) > 0) + 1])
    return values[first[np.searchsorted(first, np.arange(len(values)), side="right") - 1]]


def chosen(count: int, share: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Return a mask (count,) that picks items at random.

    Parameters
    ----------
    count : int
        Number of items.
    share : float
        Probability of each item, 0 to 1.
    rng : Generator
        Draws the mask.
    """
    return rng.random(count) < share
