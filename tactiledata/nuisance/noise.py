"""The noise of a wrench, from stretches in which nothing happens."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tactiledata.sensors.base import ForceSpecification

Array = NDArray[np.float64]

FEWEST_SAMPLES = 60
"""Samples at rest that a covariance of six components is taken from, at least."""
SMALLEST_SHARE = 1e-3
"""Of the largest variance of forces or of torques: a component that stands still is not known without error."""


@dataclass(frozen=True)
class WrenchNoise:
    """Gaussian noise of one reading.

    Parameters
    ----------
    covariance : (6, 6) N, N m
        Forces and torques are correlated: a torque about the gel's origin holds the force times its lever.
    inflation : float
        Factor on the covariance at the frames' spacing: neighbours that resemble one another count for less.
    source : str
        Where it comes from, in words.
    """

    covariance: Array
    inflation: float
    source: str

    @property
    def deviations(self) -> Array:
        """Standard deviations (6,), N and N m."""
        return np.sqrt(np.diag(self.covariance))

    def whitened(self, wrench: Array) -> Array:
        """Wrenches (…, 6) in units in which the noise is white and of variance 1."""
        return wrench @ self._whitening

    @cached_property
    def _whitening(self) -> Array:
        return np.linalg.inv(np.linalg.cholesky(self.covariance * self.inflation)).T


def noise_at_rest(stretches: Sequence[Array], lag: int = 1) -> WrenchNoise | None:
    """The noise in stretches of samples (n, 6), each about its own straight line; ``None`` where there are too few.

    Parameters
    ----------
    stretches : sequence of (n, 6)
        In free air, or while nothing moves.
    lag : int
        Samples from one frame to the next, for the correlation of neighbouring frames.
    """
    parts = [_about_line(stretch) for stretch in stretches if len(stretch) >= 4]
    rows = sum(len(part) for part in parts)
    if rows < FEWEST_SAMPLES:
        return None
    freedom = rows - 2 * len(parts)
    covariance = np.zeros((6, 6))
    for part in parts:
        covariance += part.T @ part / max(freedom, 1)
    for block in (slice(0, 3), slice(3, 6)):
        floor = SMALLEST_SHARE * covariance.diagonal()[block].max()
        covariance[block, block] += np.diag(np.maximum(floor - covariance.diagonal()[block], 0.0))
    if not covariance.diagonal().min() > 0:
        return None
    return WrenchNoise(covariance, _inflation(parts, lag), f"{rows} samples at rest")


def specified_noise(force: ForceSpecification) -> WrenchNoise:
    """The noise that the maker of a force sensor states, with the rounding to its digits."""
    of_force = force.force_noise**2 + force.force_quantum**2 / 12
    of_torque = force.torque_noise**2 + force.torque_quantum**2 / 12
    return WrenchNoise(np.diag([of_force] * 3 + [of_torque] * 3), 1.0, "the force sensor's specification")


def _about_line(stretch: Array) -> Array:
    line = np.column_stack([np.ones(len(stretch)), np.linspace(-1.0, 1.0, len(stretch))])
    return stretch - line @ np.linalg.lstsq(line, stretch, rcond=None)[0]


def _inflation(parts: Sequence[Array], lag: int) -> float:
    """(1 + r) / (1 - r) of an AR(1) process, r the mean correlation of the six components at ``lag``, not below 1."""
    long = [part for part in parts if len(part) > lag]
    together = sum(float((part[lag:, axis] * part[:-lag, axis]).sum()) / max(float((part[:, axis] ** 2).sum()), 1e-300)
                   * len(part) / (len(part) - lag) for part in long for axis in range(6))  # fmt: skip
    mean = together / (6 * len(long)) if long else 0.0
    # shorter stretches say little: what they say by chance is not taken for correlation
    doubt = 2.0 / np.sqrt(max(sum(len(part) - lag for part in long), 1))
    r = float(np.clip(mean, 0.0, 0.9)) if mean > doubt else 0.0
    return (1.0 + r) / (1.0 - r)
