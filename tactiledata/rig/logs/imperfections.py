"""What a real rig adds to the truth: noise with memory, bias and drift, quanta, repeated samples, clocks, losses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from tactiledata.arrays import RealArray, Times
from tactiledata.rig.scenario.scenario import ClockSetup, Imperfections

TORQUE_PER_FORCE = 0.02
"""m: bias and drift of torques relative to those of forces."""


def sampling_times(start_ns: int, end_ns: int, rate: float, jitter: float, rng: np.random.Generator) -> Times:
    """Moments of sampling (n,) int64 ns of the host clock: even, with jitter (s), strictly increasing."""
    period = 1e9 / rate
    # relative to the start: a float cannot hold nanoseconds since 1970
    since = np.arange(0.0, end_ns - start_ns, period)
    if jitter:
        since = since + np.clip(rng.normal(0.0, jitter * 1e9, len(since)), -0.4 * period, 0.4 * period)
    return start_ns + np.rint(since).astype(np.int64)


def stream_stamps(host_ns: Times, clock: ClockSetup) -> Times:
    """What a stream's own clock shows at moments of the host clock: host = stream + offset."""
    return host_ns - clock.offset_ns


def arrival_times(host_ns: Times, clock: ClockSetup, rng: np.random.Generator) -> Times:
    """When the recorder writes the messages: a latency later, in order, int64 ns of the host clock."""
    if not len(host_ns):
        return host_ns
    delay = clock.latency * rng.gamma(4.0, 0.25, len(host_ns)) * 1e9
    return np.maximum.accumulate(host_ns + delay.astype(np.int64))


def coloured_noise(
    count: int, scale: RealArray, rate: float, setup: Imperfections, rng: np.random.Generator
) -> RealArray:
    """White noise of standard deviations ``scale`` (k,) plus a first-order autoregressive part, (count, k)."""
    white = rng.standard_normal((count, len(scale)))
    memory = float(np.exp(-1.0 / (rate * setup.correlation_time)))
    drive = rng.standard_normal((count, len(scale))) * np.sqrt(1.0 - memory**2)
    slow = lfilter([1.0], [1.0, -memory], drive, axis=0)
    return scale * (white + setup.coloured_share * slow)


def bias_over_time(seconds: RealArray, setup: Imperfections, rng: np.random.Generator) -> RealArray:
    """Bias (n, 6), N and N m, of a force sensor at seconds (n,) since the start: constant plus a linear drift."""
    scale = np.array([1.0, 1.0, 1.0, *[TORQUE_PER_FORCE] * 3])
    constant = rng.normal(0.0, setup.force_bias, 6) * scale
    slope = rng.normal(0.0, setup.force_drift, 6) * scale / 60.0
    return constant + seconds[:, None] * slope


def quantised(wrench: RealArray, setup: Imperfections) -> RealArray:
    """Wrenches (n, 6) rounded to the sensor's quanta."""
    rounded = wrench.copy()
    for columns, quantum in ((slice(0, 3), setup.force_quantum), (slice(3, 6), setup.torque_quantum)):
        if quantum > 0:
            rounded[:, columns] = np.round(wrench[:, columns] / quantum) * quantum
    return rounded


def held(values: RealArray, seconds: RealArray, rate: float) -> RealArray:
    """Values (n, k) of which new ones come only at ``rate`` Hz: in between the last one is repeated."""
    if rate <= 0 or not len(values):
        return values
    tick = np.floor((seconds - seconds[0]) * rate + 1e-9)
    first = np.concatenate([[0], np.flatnonzero(np.diff(tick) > 0) + 1])
    return values[first[np.searchsorted(first, np.arange(len(values)), side="right") - 1]]


def chosen(count: int, share: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """A mask (count,) that picks a share of items at random."""
    return rng.random(count) < share
