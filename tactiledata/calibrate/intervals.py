"""Intervals of E, nu and mu: from the profile of the likelihood, or from other draws of the trajectories."""

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
"""Of the deviance at the ends of a 95 % interval: the 0.95 quantile of chi-square with one degree of freedom."""
CLOSE = 0.02
"""Share of an interval's half, to which its ends are found."""
DRAWS = 100


@dataclass(frozen=True)
class Intervals:
    """What is known of the three parameters.

    Parameters
    ----------
    ends : (3, 2)
        95 %, Pa for E.
    is_open : (3, 2) bool
        Whether an end is the bound's: the data alone would let the parameter go further.
    correlation : (3, 3)
    inflation : (3,)
        By how much trajectories vary more than the noise explains, as a factor on variances.
    """

    ends: Array
    is_open: NDArray[np.bool_]
    correlation: Array
    inflation: Array


def profile_intervals(loss: VectorLoss, bounds: Bounds, optimum: Array) -> Intervals:
    """95 % profile-likelihood intervals, the other parameters, offsets and zeros fitted anew at each value."""
    best = polish(loss, bounds, bounds.shares(optimum))
    known = spread(loss, bounds, best.shares)
    ends, is_open = np.empty((3, 2)), np.zeros((3, 2), dtype=bool)
    for k in range(3):
        for side, direction in enumerate((-1, 1)):
            ends[k, side], is_open[k, side] = _end(loss, bounds, best, known, k, direction)
    scaled = np.asarray(bounds.low)[:, None] + ends * bounds.span[:, None]
    return Intervals(scaled, is_open, known.correlation, known.inflation)


def intervals_hold(loss: VectorLoss, bounds: Bounds, optimum: Array, values: Array) -> NDArray[np.bool_]:
    """Whether each parameter's 95 % interval holds a value (3,): where its profile has not risen too far yet.

    One fit each, where `profile_intervals` needs some fifteen to find the ends.
    """
    best = polish(loss, bounds, bounds.shares(optimum))
    known = spread(loss, bounds, best.shares)
    sought = bounds.shares(values)
    held = np.empty(3, dtype=bool)
    for k in range(3):
        moved = known.covariance[:, k] / max(known.covariance[k, k], 1e-300)
        place = best.shares + moved * (sought[k] - best.shares[k])
        place[k] = sought[k]
        held[k] = polish(loss, bounds, place, held=k).cost - best.cost <= RISE * known.inflation[k]
    return held


def _end(loss: VectorLoss, bounds: Bounds, best: Optimum, known: Spread, k: int, direction: int) -> tuple[float, bool]:
    """Where the profile has risen by ``RISE``, a share of the box, and whether the box ends before."""
    rise = RISE * float(known.inflation[k])
    limit = 0.0 if direction < 0 else 1.0
    room = abs(limit - best.shares[k])
    guess = np.sqrt(rise * max(known.covariance[k, k], 1e-16))
    moved = known.covariance[:, k] / max(known.covariance[k, k], 1e-300)

    def deviance(distance: float) -> float:
        place = best.shares + moved * direction * distance
        place[k] = best.shares[k] + direction * distance
        return polish(loss, bounds, place, held=k).cost - best.cost - rise

    if room <= 1e-9 or deviance(room) < 0:
        return limit, True
    return float(best.shares[k] + direction * _crossing(deviance, float(guess), room, -rise)), False


def _crossing(height: Callable[[float], float], guess: float, room: float, depth: float) -> float:
    """Where a rising, nearly parabolic function is 0 between 0 (where it is ``depth`` < 0) and ``room`` (above 0)."""
    low, high = 0.0, room
    value_low, value_high = depth, np.inf
    place = min(guess, 0.9 * room)
    for _ in range(40):
        value = height(place)
        if value < 0:
            low, value_low = place, value
        else:
            high, value_high = place, value
        if high - low < CLOSE * high:
            break
        # a parabola from the optimum has its root there; kept inside the bracket
        root = place * np.sqrt(-depth / max(value - depth, -depth * 1e-6))
        inner = 0.02 * (high - low)
        nudge = 0.4 * CLOSE * root
        root = root + (nudge if value < 0 else -nudge)
        place = float(np.clip(root, low + inner, high - inner))
    if not np.isfinite(value_high):
        return high
    return low + (high - low) * -value_low / (value_high - value_low)


def bootstrap_intervals(loss: NormLoss, bounds: Bounds, optimum: Array, seed: int, draws: int = DRAWS) -> Intervals:
    """95 % intervals of the norm loss, which is no likelihood: percentiles over other draws of the trajectories."""
    chance = np.random.default_rng([seed, 1])
    count = len(loss.response.starts)
    drawn = (np.bincount(chance.integers(0, count, count), minlength=count) for _ in range(draws))
    found = np.array([descend(replace(loss, shares=shares.astype(float)), bounds, optimum) for shares in drawn])
    ends = np.percentile(found, [2.5, 97.5], axis=0).T
    margin = 1e-3 * bounds.span
    is_open = np.stack([ends[:, 0] <= bounds.low + margin, ends[:, 1] >= bounds.high - margin], axis=1)
    deviations = found.std(axis=0)
    covariance = np.cov(found.T)
    correlation = covariance / np.maximum(np.outer(deviations, deviations), 1e-300) * (draws - 1) / draws
    return Intervals(ends, is_open, np.where(np.eye(3) > 0, 1.0, correlation), np.ones(3))
