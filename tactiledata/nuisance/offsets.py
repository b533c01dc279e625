"""Contact offset of each trajectory: how much deeper the indenter is than recorded, fitted by Newton's method."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from tactiledata.arrays import Array, Indices

PRIOR = 4e-5
"""Standard deviation of offsets, m: the repeatability of the arm, and of the tip in its holder."""
FARTHEST = 2.0e-4
"""Largest offset, m: one of more than five prior deviations has another cause than repeatability."""
ROUNDS = 12
"""Most Newton steps."""
HALVINGS = 6
"""Most halvings of a Newton step that overshoots."""
CLOSE = 1e-9
"""Largest change of an offset, m, at which the fit ends."""


@dataclass(frozen=True)
class OffsetSeries:
    """Wrenches as a quadratic of the offset z: ``level + slope z + curvature z**2``.

    Parameters
    ----------
    level, slope, curvature : (n, k)
        Wrenches at offset 0, and their change per m and per m^2, in the unit of the wrenches (whitened or not).
    """

    level: Array
    slope: Array
    curvature: Array

    def at(self, offsets: Array) -> Array:
        """Wrenches (n, k) at an offset for each row (n,), m."""
        z = offsets[:, None]
        return self.level + z * (self.slope + z * self.curvature)

    def times(self, factors: Array) -> OffsetSeries:
        """Return the series with each row multiplied by a factor (n,)."""
        return OffsetSeries(*(part * factors[:, None] for part in (self.level, self.slope, self.curvature)))


def profile_offsets(measured: Array, series: OffsetSeries, starts: Indices, prior: float = PRIOR) -> Array:
    """Return the offset (t,), m, of each trajectory that minimises its whitened squared residual plus its prior.

    Parameters
    ----------
    measured : (n, k)
        Whitened measured wrenches.
    series : OffsetSeries
        Whitened simulated wrenches of the same n rows, over the offset.
    starts : (t,)
        First row of each trajectory, ascending.
    prior : m
        Standard deviation of the offsets about 0; 0 leaves them at 0.
    """
    offsets = np.zeros(len(starts))
    if prior <= 0:
        return offsets
    # the cost of a quadratic series is a quartic of the offset
    quartic = _cost(measured, series, starts, prior)
    first = _derivative(quartic)
    _descend(quartic, first, _derivative(first), 2.0 * prior**-2, offsets)
    return offsets


@njit(nogil=True, cache=True)
def _descend(quartic: Array, first: Array, second: Array, least_curvature: float, offsets: Array) -> None:
    """Newton's method for each trajectory at once; the ``offsets`` (t,) that it starts from are changed in place.

    Parameters
    ----------
    quartic, first, second : (5, t), (4, t), (3, t)
        Costs as polynomials of the offset, and their derivatives, lowest power first.
    least_curvature : float
        What stands for a curvature that is not above 0.
    offsets : (t,) m
        The start on entry, the result on return.
    """
    count = len(offsets)
    cost = np.array([_at(quartic[:, place], offsets[place]) for place in range(count)])
    for _ in range(ROUNDS):
        largest_step = 0.0
        for place in range(count):
            here = offsets[place]
            curvature = _at(second[:, place], here)
            step = -_at(first[:, place], here) / (curvature if curvature > 0 else least_curvature)
            # a step that overshoots is halved; the next round linearises anew
            for _ in range(HALVINGS):
                trial = min(max(here + step, -FARTHEST), FARTHEST)
                trial_cost = _at(quartic[:, place], trial)
                if not trial_cost > cost[place]:
                    offsets[place], cost[place] = trial, trial_cost
                    largest_step = max(largest_step, abs(trial - here))
                    break
                step /= 2.0
        if largest_step < CLOSE:
            break


def _cost(measured: Array, series: OffsetSeries, starts: Indices, prior: float) -> Array:
    """Each trajectory's sum of squares as a polynomial of its offset: coefficients (5, t), lowest power first."""
    residual, slope, curvature = measured - series.level, series.slope, series.curvature

    def dot(a: Array, b: Array) -> Array:
        """Inner products (t,) of the rows of each trajectory."""
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
    """Coefficients (p - 1, t) of the derivatives of polynomials (p, t), lowest power first."""
    return polynomial[1:] * np.arange(1, len(polynomial))[:, None]


@njit(nogil=True, cache=True)
def _at(polynomial: Array, place: float) -> float:
    """Value of a polynomial (p,) at a place, by Horner's scheme."""
    value = 0.0
    for power in range(len(polynomial) - 1, -1, -1):
        value = value * place + polynomial[power]
    return value
