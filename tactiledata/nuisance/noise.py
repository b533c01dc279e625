"""Noise of a wrench at a frame, from stretches of readings at rest or from a data sheet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array
from tactiledata.sensors.base import ForceSpecification

FEWEST_SAMPLES = 60
"""Fewest samples at rest from which a covariance of six components is estimated."""
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
    memory : float
        Variance of the mean of many consecutive readings over that of as many independent ones; at least 1.
    """

    covariance: Array
    inflation: float
    source: str
    reading_variance: float = 1.0
    memory: float = 1.0

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
    if not covariance.diagonal().min() > 0:
        return None
    variances = reading_covariance.diagonal()
    is_noisy = variances > 0
    ratio = float((variances[is_noisy] / covariance.diagonal()[is_noisy]).mean())
    inflation, memory = _inflation(parts, lag, own_share), _memory(parts)
    return WrenchNoise(covariance, inflation, f"{rows} samples at rest", ratio, memory)


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


def _memory(parts: Sequence[Array]) -> float:
    """Return 1 + 2 (r1 + r2 + ...) with the mean correlation r of the components at each lag, at least 1.

    The sum ends before the first lag whose correlation may be chance, and at a quarter of a stretch.
    """
    variances = _lagged(parts, 0).diagonal()
    is_noisy = variances > 0
    total = 1.0
    for lag in range(1, max((len(part) for part in parts), default=0) // 4 + 1):
        chance_correlation = 2.0 / np.sqrt(max(sum(max(len(part) - lag, 0) for part in parts), 1))
        correlation = float((_lagged(parts, lag).diagonal()[is_noisy] / variances[is_noisy]).mean())
        if not correlation > chance_correlation:
            break
        total += 2.0 * correlation
    return total


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
