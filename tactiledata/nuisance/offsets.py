"""Where the contact begins: each trajectory's own offset, profiled by Newton steps that are linearised anew."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

PRIOR = 4e-5
"""m, standard deviation: the repeatability of the arm, and of the tip in its holder."""
FARTHEST = 2.0e-4
"""m: an offset larger than five times its prior is not one of repeatability."""
ROUNDS = 12
CLOSE = 1e-9
"""m: the offsets stand still."""


@dataclass(frozen=True)
class OffsetSeries:
    """Wrenches as a quadratic of the offset: ``level + slope z + curvature z**2``, each (n, k)."""

    level: Array
    slope: Array
    curvature: Array

    def at(self, offsets: Array) -> Array:
        """Wrenches (n, k) at offsets (n,), m."""
        z = offsets[:, None]
        return self.level + z * (self.slope + z * self.curvature)


def profile_offsets(measured: Array, series: OffsetSeries, starts: Indices, prior: float = PRIOR) -> Array:
    """The offset (t,), m, of each trajectory that makes its whitened residual and its prior least.

    Parameters
    ----------
    measured : (n, k)
        Whitened, as the series.
    starts : (t,)
        First row of each trajectory, ascending.
    prior : m
        Standard deviation of the offsets about 0; 0 leaves them at 0.
    """
    offsets = np.zeros(len(starts))
    if prior <= 0:
        return offsets
    counts = np.diff(starts, append=len(measured))
    value = _value(measured, series, starts, counts, offsets, prior)
    for _ in range(ROUNDS):
        z = np.repeat(offsets, counts)[:, None]
        residual = measured - series.at(z[:, 0])
        tangent = series.slope + 2.0 * z * series.curvature
        gradient = _sums(tangent * residual, starts) - offsets / prior**2
        stiffness = _sums(tangent * tangent, starts) + 1.0 / prior**2
        step = gradient / stiffness
        tried = np.clip(offsets + step, -FARTHEST, FARTHEST)
        reached = _value(measured, series, starts, counts, tried, prior)
        better = reached <= value
        # a step that overshoots is halved once; the next round linearises anew
        half = np.clip(offsets + step / 2, -FARTHEST, FARTHEST)
        tried = np.where(better, tried, half)
        moved = np.abs(tried - offsets).max(initial=0.0)
        offsets = tried
        value = _value(measured, series, starts, counts, offsets, prior)
        if moved < CLOSE:
            break
    return offsets


def _value(
    measured: Array, series: OffsetSeries, starts: Indices, counts: Indices, offsets: Array, prior: float
) -> Array:
    residual = measured - series.at(np.repeat(offsets, counts))
    return _sums(residual * residual, starts) + (offsets / prior) ** 2


def _sums(rows: Array, starts: Indices) -> Array:
    return np.add.reduceat(rows.sum(axis=1), starts)
