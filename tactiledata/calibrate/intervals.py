"""95 % intervals of E, nu and mu: from the profile likelihood, or from a bootstrap over trajectories."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.least_squares import Optimum, Spread, polish, spread
from tactiledata.calibrate.losses import NormLoss, VectorLoss
from tactiledata.calibrate.search import descend

RISE = 3.841
"""Rise of the deviance at the ends of a 95 % interval: 0.95 quantile of chi-square with one degree of freedom."""
CLOSE = 0.02
"""Relative width of the bracket of an interval's end at which the search ends."""
DRAWS = 100
"""Bootstrap samples of the trajectories."""


@dataclass(frozen=True)
class Intervals:
    """95 % intervals of E, nu and mu, their correlation, and the factor by which their variances were inflated.

    Parameters
    ----------
    ends : (3, 2)
        Lower and upper ends; Pa for E.
    is_open : (3, 2) bool
        True where an end is that of the box: the data alone would allow values beyond it.
    correlation : (3, 3)
        Correlation of the three estimates.
    inflation : (3,)
        Factor on variances by which trajectories disagree beyond the noise; 1 where they do not.
    """

    ends: Array
    is_open: NDArray[np.bool_]
    correlation: Array
    inflation: Array


def profile_intervals(loss: VectorLoss, bounds: Bounds, optimum: Array) -> Intervals:
    """95 % profile-likelihood intervals of E, nu and mu.

    The other parameters, the contact offsets and the force zeros are fitted anew at each value of a parameter.

    Parameters
    ----------
    loss : VectorLoss
        Its squared residual is the deviance.
    bounds : Bounds
        The box in which ends are sought.
    optimum : (3,)
        E (Pa), nu, mu at or near the minimum.
    """
    best = polish(loss, bounds, bounds.shares(optimum))
    curvature = spread(loss, bounds, best.shares)
    ends, is_open = np.empty((3, 2)), np.zeros((3, 2), dtype=bool)
    for k in range(3):
        for side, direction in enumerate((-1, 1)):
            ends[k, side], is_open[k, side] = _end(loss, bounds, best, curvature, k, direction)
    scaled = np.asarray(bounds.low)[:, None] + ends * bounds.span[:, None]
    return Intervals(scaled, is_open, curvature.correlation, curvature.inflation)


def intervals_hold(loss: VectorLoss, bounds: Bounds, optimum: Array, values: Array) -> NDArray[np.bool_]:
    """Whether the 95 % interval of each parameter holds a value: mask (3,).

    The profile at the value is compared with ``RISE``: one fit for each parameter, where `profile_intervals` needs
    about fifteen to find the ends.

    Parameters
    ----------
    loss : VectorLoss
        Its squared residual is the deviance.
    bounds : Bounds
        The box of the fits.
    optimum : (3,)
        E (Pa), nu, mu at or near the minimum.
    values : (3,)
        E (Pa), nu, mu to be tested, each on its own.
    """
    best = polish(loss, bounds, bounds.shares(optimum))
    curvature = spread(loss, bounds, best.shares)
    tested = bounds.shares(values)
    is_inside = np.empty(3, dtype=bool)
    for k in range(3):
        moved = curvature.covariance[:, k] / max(curvature.covariance[k, k], 1e-300)
        start = best.shares + moved * (tested[k] - best.shares[k])
        start[k] = tested[k]
        is_inside[k] = polish(loss, bounds, start, held=k).cost - best.cost <= RISE * curvature.inflation[k]
    return is_inside


def _end(
    loss: VectorLoss, bounds: Bounds, best: Optimum, curvature: Spread, k: int, direction: int
) -> tuple[float, bool]:
    """Return one end of parameter k's interval, as a share of the box, and whether it is the bound of the box.

    ``direction`` is -1 for the lower end and 1 for the upper.
    """
    rise = RISE * float(curvature.inflation[k])
    limit = 0.0 if direction < 0 else 1.0
    distance_to_bound = abs(limit - best.shares[k])
    guess = np.sqrt(rise * max(curvature.covariance[k, k], 1e-16))
    # the other parameters start where they move to when parameter k is shifted
    moved = curvature.covariance[:, k] / max(curvature.covariance[k, k], 1e-300)

    def deviance(distance: float) -> float:
        """Rise of the profile at a distance from the optimum, in shares of the box, minus ``RISE`` as inflated."""
        start = best.shares + moved * direction * distance
        start[k] = best.shares[k] + direction * distance
        return polish(loss, bounds, start, held=k).cost - best.cost - rise

    if distance_to_bound <= 1e-9 or deviance(distance_to_bound) < 0:
        return limit, True
    return float(best.shares[k] + direction * _crossing(deviance, float(guess), distance_to_bound, -rise)), False


def _crossing(height: Callable[[float], float], guess: float, upper: float, depth: float) -> float:
    """Root of a rising, nearly parabolic function between 0, where it is ``depth`` < 0, and ``upper``, where it is > 0.

    ``guess`` is a first estimate of the root.
    """
    low, high = 0.0, upper
    height_low, height_high = depth, np.inf
    trial = min(guess, 0.9 * upper)
    for _ in range(40):
        trial_height = height(trial)
        if trial_height < 0:
            low, height_low = trial, trial_height
        else:
            high, height_high = trial, trial_height
        if high - low < CLOSE * high:
            break
        # root of the parabola through the optimum, moved slightly outwards so that it ends up on the other side of the
        # true root, and kept inside the bracket
        root = trial * np.sqrt(-depth / max(trial_height - depth, -depth * 1e-6))
        inner = 0.02 * (high - low)
        nudge = 0.4 * CLOSE * root
        root = root + (nudge if trial_height < 0 else -nudge)
        trial = float(np.clip(root, low + inner, high - inner))
    if not np.isfinite(height_high):
        return high
    return low + (high - low) * -height_low / (height_high - height_low)


def bootstrap_intervals(loss: NormLoss, bounds: Bounds, optimum: Array, seed: int, draws: int = DRAWS) -> Intervals:
    """95 % percentile intervals of the norm loss from a bootstrap over trajectories; the loss is not a likelihood.

    Parameters
    ----------
    loss : NormLoss
        Minimised again for each bootstrap sample.
    bounds : Bounds
        The box that is searched.
    optimum : (3,)
        E (Pa), nu, mu from which each search starts.
    seed : int
        Seed of the samples.
    draws : int
        Number of samples.
    """
    rng = np.random.default_rng([seed, 1])
    count = len(loss.response.starts)
    drawn = (np.bincount(rng.integers(0, count, count), minlength=count) for _ in range(draws))
    optima = np.array([descend(replace(loss, shares=shares.astype(float)), bounds, optimum) for shares in drawn])
    # an end within a thousandth of the box's bound counts as open
    ends = np.percentile(optima, [2.5, 97.5], axis=0).T
    margin = 1e-3 * bounds.span
    is_open = np.stack([ends[:, 0] <= bounds.low + margin, ends[:, 1] >= bounds.high - margin], axis=1)
    deviations = optima.std(axis=0)
    covariance = np.cov(optima.T)
    correlation = covariance / np.maximum(np.outer(deviations, deviations), 1e-300) * (draws - 1) / draws
    return Intervals(ends, is_open, np.where(np.eye(3) > 0, 1.0, correlation), np.ones(3))
