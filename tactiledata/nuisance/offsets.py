"""Where the contact begins: each trajectory's own offset, profiled by Newton steps that are linearised anew."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array, Indices

PRIOR = 4e-5
"""m, standard deviation: the repeatability of the arm, and of the tip in its holder."""
FARTHEST = 2.0e-4
"""m: an offset larger than five times its prior is not one of repeatability."""
ROUNDS = 12
HALVINGS = 6
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

    def times(self, factors: Array) -> OffsetSeries:
        """Each row times a factor (n,)."""
        return OffsetSeries(*(part * factors[:, None] for part in (self.level, self.slope, self.curvature)))


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
    quartic = _cost(measured, series, starts, prior)
    first = _derivative(quartic)
    second = _derivative(first)
    cost = _at(quartic, offsets)
    for _ in range(ROUNDS):
        bend = _at(second, offsets)
        step = -_at(first, offsets) / np.where(bend > 0, bend, 2.0 * prior**-2)
        # a step that overshoots is halved; the next round linearises anew
        for _ in range(HALVINGS):
            tried = np.clip(offsets + step, -FARTHEST, FARTHEST)
            reached = _at(quartic, tried)
            is_worse = reached > cost
            if not is_worse.any():
                break
            step = np.where(is_worse, step / 2, step)
        tried = np.where(is_worse, offsets, tried)
        moved = np.abs(tried - offsets).max(initial=0.0)
        offsets, cost = tried, np.where(is_worse, cost, reached)
        if moved < CLOSE:
            break
    return offsets


def _cost(measured: Array, series: OffsetSeries, starts: Indices, prior: float) -> Array:
    """Each trajectory's sum of squares as a polynomial of its offset: coefficients (5, t), lowest power first."""
    residual, slope, curvature = measured - series.level, series.slope, series.curvature

    def dot(a: Array, b: Array) -> Array:
        return np.add.reduceat(np.einsum("nk,nk->n", a, b), starts)

    return np.stack(
        [
            dot(residual, residual),
            -2.0 * dot(residual, slope),
            dot(slope, slope) - 2.0 * dot(residual, curvature) + prior**-2,
            2.0 * dot(slope, curvature),
            dot(curvature, curvature),
        ]
    )


def _derivative(polynomial: Array) -> Array:
    return polynomial[1:] * np.arange(1, len(polynomial))[:, None]


def _at(polynomial: Array, place: Array) -> Array:
    value = np.zeros_like(place)
    for coefficient in polynomial[::-1]:
        value = value * place + coefficient
    return value
