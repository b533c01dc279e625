"""Noise of a wrench at a frame, from stretches of readings at rest or from a data sheet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import nnls

from tactiledata.arrays import Array, Indices
from tactiledata.sensors.base import ForceSpecification

FEWEST_SAMPLES = 60
"""Fewest samples at rest from which a covariance of six components is estimated."""
MEMORIES = (0.8, 2, 5, 12, 30, 80)
"""Time constants, in readings, of parts of the noise; those are fitted that are up to half of a stretch long."""
LEAST_CORRELATION = 1e-3
"""Correlation below which two readings count as independent."""
SMALLEST_FACTOR = 0.2
"""Smallest deviation of a mean over that of a wrench at one frame: noise that is slower than free air lasts remains."""
SMALLEST_DEVIATION = 1e-7
"""Standard deviation, N and N m, below which readings count as all the same."""
SMALLEST_SHARE = 1e-3
"""Floor of a variance, as a share of the largest of the forces or torques: no component is without error."""


@dataclass(frozen=True)
class WrenchNoise:
    """Gaussian noise of a wrench at one frame, after the interpolation between two readings.

    Parameters
    ----------
    covariance : (6, 6) N, N m
        Forces and torques are correlated: a torque about the gel's origin contains the force times its lever.
    inflation : float
        Factor on the covariance for frames that are correlated in time.
    source : str
        Where the figures come from, in words.
    reading_variance : float
        Variance of a single reading of the sensor over that of a wrench at a frame, mean of six components.
    correlations : tuple of float
        Correlation of two readings that are 1, 2, ... places apart, as far as it is more than chance.
    """

    covariance: Array
    inflation: float
    source: str
    reading_variance: float = 1.0
    correlations: tuple[float, ...] = ()

    @property
    def memory(self) -> float:
        """Variance of the mean of many consecutive readings over that of as many independent ones; at least 1."""
        return 1.0 + 2.0 * sum(self.correlations)

    def mean_factors(self, readings: Indices) -> Array:
        """Return the deviation (n,) of means of consecutive readings over that of a wrench at one frame.

        The variance of a mean of m readings is that of a reading times (1 + 2 sum over k < m of (1 - k / m) r_k) / m,
        with the correlation r_k of readings k places apart. No factor is above 1, nor below ``SMALLEST_FACTOR``.

        Parameters
        ----------
        readings : (n,)
            Number of readings of each mean; 0 for a wrench that is interpolated, whose factor is 1.
        """
        lags = np.arange(1, len(self.correlations) + 1)
        counts = np.maximum(readings, 1)[:, None]
        shared = (np.maximum(1.0 - lags / counts, 0.0) * np.array(self.correlations)).sum(axis=1)
        variances = self.reading_variance * (1.0 + 2.0 * shared) / counts[:, 0]
        factors = np.clip(np.sqrt(variances), SMALLEST_FACTOR, 1.0)
        return np.where(readings > 0, factors, 1.0)

    @property
    def deviations(self) -> Array:
        """Standard deviations (6,) of one frame, N and N m, without the inflation."""
        return np.sqrt(np.diag(self.covariance))

    def whitened(self, wrench: Array) -> Array:
        """Return wrenches (…, 6) in units in which the inflated noise is white and of variance 1."""
        return wrench @ self._whitening

    @cached_property
    def _whitening(self) -> Array:
        """Matrix (6, 6) by which wrenches are multiplied from the right."""
        return np.linalg.inv(np.linalg.cholesky(self.covariance * self.inflation)).T


def noise_at_rest(
    stretches: Sequence[Array], lag: int = 1, fractions: Sequence[float] | Array = (0.0,)
) -> WrenchNoise | None:
    """Return the noise of a wrench at a frame, from readings at rest; ``None`` where there are too few readings.

    A wrench at a frame is ``(1 - u) x[i] + u x[i + 1]``, interpolated between two readings. With the covariances C0 of
    a reading and C1 of neighbouring readings, its covariance is ``m C0 + (1 - m) C1`` where ``m`` is the mean of
    ``(1 - u)**2 + u**2``: two thirds of a reading's variance where readings are independent and u is uniform.

    Parameters
    ----------
    stretches : sequence of (n, 6), N, N m
        Consecutive readings in free air, or while nothing moves, repeated ones included. A straight line is subtracted
        from each.
    lag : int
        Readings from one frame to the next, for the correlation of neighbouring frames.
    fractions : (f,)
        Position of frames between two readings, 0 to 1; 0 where frames and readings coincide.
    """
    parts = [_about_line(stretch) for stretch in stretches if len(stretch) >= 4]
    rows = sum(len(part) for part in parts)
    if rows < FEWEST_SAMPLES:
        return None
    # share of a reading's own covariance after the interpolation
    u = np.asarray(fractions, dtype=np.float64)
    own_share = float(((1.0 - u) ** 2 + u**2).mean()) if len(u) else 1.0
    reading_covariance = _lagged(parts, 0)
    covariance = own_share * reading_covariance + (1.0 - own_share) * _lagged(parts, 1)
    # raise variances of a component that stands still, among forces and among torques
    for block in (slice(0, 3), slice(3, 6)):
        floor = SMALLEST_SHARE * covariance.diagonal()[block].max()
        covariance[block, block] += np.diag(np.maximum(floor - covariance.diagonal()[block], 0.0))
    # readings that all are the same, as within a dead band, tell no noise: what is left of them is rounding
    largest = [covariance.diagonal()[block].max() for block in (slice(0, 3), slice(3, 6))]
    if not min(largest) > SMALLEST_DEVIATION**2 or not covariance.diagonal().min() > 0:
        return None
    variances = reading_covariance.diagonal()
    is_noisy = variances > 0
    ratio = float((variances[is_noisy] / covariance.diagonal()[is_noisy]).mean())
    inflation, correlations = _inflation(parts, lag, own_share), _correlations(stretches)
    return WrenchNoise(covariance, inflation, f"{rows} samples at rest", ratio, correlations)


def specified_noise(force: ForceSpecification) -> WrenchNoise:
    """Return the noise that a force sensor's data sheet states, with the rounding of its readings."""
    # a uniform error of width q, the quantum, has the variance q^2 / 12
    force_variance = force.force_noise**2 + force.force_quantum**2 / 12
    torque_variance = force.torque_noise**2 + force.torque_quantum**2 / 12
    return WrenchNoise(np.diag([force_variance] * 3 + [torque_variance] * 3), 1.0, "the force sensor's specification")


def _about_line(stretch: Array) -> Array:
    """Readings (n, 6) minus their least-squares straight line in time."""
    line = np.column_stack([np.ones(len(stretch)), np.linspace(-1.0, 1.0, len(stretch))])
    return stretch - line @ np.linalg.lstsq(line, stretch, rcond=None)[0]


def _lagged(parts: Sequence[Array], lag: int) -> Array:
    """Return the symmetric covariance (6, 6) of readings ``lag`` places apart, each part about its own line."""
    long = [part for part in parts if len(part) > lag]
    pairs = sum(len(part) - lag for part in long)
    # a line takes two numbers from each part
    rows = sum(len(part) for part in parts)
    corrected = rows / max(rows - 2 * len(parts), 1)
    summed = sum((part[lag:].T @ part[: len(part) - lag] for part in long), np.zeros((6, 6)))
    return np.asarray(corrected * (summed + summed.T) / (2.0 * max(pairs, 1)))


def _correlations(stretches: Sequence[Array]) -> tuple[float, ...]:
    """Return the mean correlation of the components of readings 1, 2, ... places apart, to the last that counts.

    The noise is taken as a sum of white noise and of parts that forget with the time constants ``MEMORIES``. Their
    shares, none negative, are fitted to the covariances that the stretches (n, 6) have about their means, up to a
    quarter of a stretch. A mean takes a part of slow noise with it; the covariances that are expected of each part lack
    the same.
    """
    parts = [stretch - stretch.mean(axis=0) for stretch in stretches if len(stretch) >= 4]
    scale = np.sqrt(np.mean([(part**2).mean(axis=0) for part in parts], axis=0)) if parts else np.zeros(6)
    if not (scale > 0).any():
        return ()
    lags = np.arange(max(len(part) for part in parts) // 4 + 1)
    scaled = [part[:, scale > 0] / scale[scale > 0] for part in parts]
    sums = [sum(float((one[k:] * one[: max(len(one) - k, 0)]).mean(axis=1).sum()) for one in scaled) for k in lags]
    # slower parts than half of a stretch cannot be told from its mean
    known = np.array([time for time in MEMORIES if time <= max(len(part) for part in parts) / 2])
    memories = np.exp(-1.0 / known)
    curves = np.column_stack([lags == 0, *(memory**lags for memory in memories)])
    lengths, counts = np.unique([len(part) for part in parts], return_counts=True)
    expected = sum(count * _sums_about_mean(int(n), memories, lags) for n, count in zip(lengths, counts, strict=True))
    # each sum of products varies as the number of its pairs
    pairs = sum(count * np.maximum(n - lags, 0) for n, count in zip(lengths, counts, strict=True))
    weights = 1.0 / np.sqrt(np.maximum(pairs, 1))
    shares, _ = nnls(np.asarray(expected) * weights[:, None], np.array(sums) * weights)
    whole = np.arange(1, 4 * MEMORIES[-1])
    found = (memories ** whole[:, None]) @ shares[1:] / max(float((curves[0] * shares).sum()), 1e-300)
    return tuple(float(one) for one in found[found > LEAST_CORRELATION])


def _sums_about_mean(count: int, memories: Array, lags: Indices) -> Array:
    """Return the expected sums (k, 1 + p) of products of readings about their mean, of parts with a variance of 1.

    Parameters
    ----------
    count : int
        Number n of readings of the stretch.
    memories : (p,)
        Correlation of neighbouring readings of each part; white noise comes first, without one.
    lags : (k,)
        Number of places between the two readings of a product.
    """
    distances = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    columns = []
    for memory in (0.0, *memories):
        covariance = memory**distances
        covariance = covariance - covariance.mean(axis=0) - covariance.mean(axis=1)[:, None] + covariance.mean()
        columns.append([float(np.trace(covariance, offset=int(lag))) if lag < count else 0.0 for lag in lags])
    return np.array(columns).T


def _inflation(parts: Sequence[Array], lag: int, own: float) -> float:
    """Return (1 + r) / (1 - r) of an AR(1) process, not below 1.

    r is the mean correlation of the six components at two frames that follow one another.

    Parameters
    ----------
    parts : sequence of (n, 6)
        Readings at rest, about their lines.
    lag : int
        Readings from one frame to the next.
    own : float
        Share of a reading's own covariance in that of an interpolated value.
    """
    shared = 0.5 * (1.0 - own)

    def covariance_at(distance: int) -> Array:
        """Covariances (6,) of interpolated values ``distance`` readings apart; two readings enter each value."""
        return np.asarray(
            own * _lagged(parts, distance).diagonal()
            + shared * (_lagged(parts, abs(distance - 1)).diagonal() + _lagged(parts, distance + 1).diagonal())
        )

    variances = covariance_at(0)
    is_noisy = variances > 0
    mean = float((covariance_at(lag)[is_noisy] / variances[is_noisy]).mean()) if is_noisy.any() else 0.0
    # a correlation within two standard errors of 0 may be chance: it is taken as 0
    chance_correlation = 2.0 / np.sqrt(max(sum(max(len(part) - lag, 0) for part in parts), 1))
    r = float(np.clip(mean, 0.0, 0.9)) if mean > chance_correlation else 0.0
    return (1.0 + r) / (1.0 - r)
