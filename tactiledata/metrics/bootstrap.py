"""Intervals of scores by drawing whole trajectories: frames of one touch are nearly copies of one another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UsageError

LEAST_GROUPS = 5
"""Least number of trajectories for an interval: with fewer it would be far too narrow."""


@dataclass(frozen=True)
class Interval:
    """A statistic with its interval.

    Parameters
    ----------
    value : float
        The statistic of all samples that have a value.
    low, high : float
        Ends of the interval; NaN where there are too few trajectories.
    samples, trajectories : int
        Numbers of samples and trajectories that took part.
    left_out : int
        Number of samples without a value (an empty contact mask), which took no part.
    """

    value: float
    low: float
    high: float
    samples: int
    trajectories: int
    left_out: int

    def __str__(self) -> str:
        """Return the value with its interval in brackets, four digits each."""
        if not np.isfinite(self.low):
            return f"{self.value:.4g}"
        return f"{self.value:.4g} [{self.low:.4g}, {self.high:.4g}]"


def bootstrap(
    values: Any,
    trajectories: Any,
    *,
    statistic: Callable[[NDArray[Any]], float] | None = None,
    rounds: int = 1000,
    level: float = 0.95,
    seed: int = 0,
) -> Interval:
    """Return a statistic of values over samples, and its percentile interval over trajectories.

    Parameters
    ----------
    values : (n,) or (n, ...)
        Score of each sample; NaN where it has none. For the difference of two methods on the same samples, the
        differences. With a ``statistic``, anything that has a row for each sample, row numbers included.
    trajectories : (n,)
        Trajectory of each sample; any names.
    statistic : callable, optional
        Gives a float for the rows that were drawn; the mean unless stated.
    rounds : int
        Number of draws.
    level : float
        Share of the draws that the interval holds.
    seed : int
        Seed of the draws.

    Raises
    ------
    UsageError
        Lengths that differ, or no sample with a value.

    Examples
    --------
    >>> bootstrap([1.0, 1.0, 3.0], ["a", "a", "b"]).value
    1.6666666666666667
    """
    rows, groups = np.asarray(values, np.float64), np.asarray(trajectories)
    if rows.ndim == 0 or groups.shape != rows.shape[:1]:
        raise UsageError(f"{rows.shape} values for {groups.shape} trajectories", "a trajectory for each value", "")
    # samples that have a value, and the trajectory of each
    is_there = ~np.isnan(rows.reshape(len(rows), -1)).any(axis=1) if len(rows) else np.zeros(0, bool)
    if not is_there.any():
        raise UsageError(f"none of {len(rows)} samples has a value", "at least one", "Are all contact masks empty?")
    kept = rows[is_there]
    names, group = np.unique(groups[is_there], return_inverse=True)
    # the statistic of all, and that of each draw of trajectories
    rng = np.random.default_rng(seed)
    if statistic is None:
        value, draws = float(kept.mean()), _means(kept, group, len(names), rounds, rng)
    else:
        value, draws = float(statistic(kept)), _drawn(statistic, kept, group, len(names), rounds, rng)
    low = high = np.nan
    if len(names) >= LEAST_GROUPS:
        # a draw is chosen, not interpolated: PSNR may be infinite
        low, high = np.quantile(draws, [(1 - level) / 2, (1 + level) / 2], method="inverted_cdf")
    return Interval(value, float(low), float(high), len(kept), len(names), int((~is_there).sum()))


def _means(
    values: NDArray[np.float64], group: NDArray[np.intp], count: int, rounds: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Means (rounds,) of draws of trajectories, from the sum and the size of each trajectory alone.

    Parameters
    ----------
    values : (n,)
        Score of each sample.
    group : (n,)
        Number of the trajectory of each sample, from 0.
    count : int
        Number of trajectories.
    rounds : int
        Number of draws.
    rng : Generator
        Source of the draws.
    """
    if values.ndim != 1:
        raise UsageError(f"values of shape {values.shape}", "(n,), or a statistic of the rows", "")
    sums, sizes = np.bincount(group, values, count), np.bincount(group, minlength=count)
    drawn = rng.integers(0, count, (rounds, count))
    return sums[drawn].sum(axis=1) / sizes[drawn].sum(axis=1)


def _drawn(
    statistic: Callable[[NDArray[Any]], float],
    values: NDArray[np.float64],
    group: NDArray[np.intp],
    count: int,
    rounds: int,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Statistics (rounds,) of the rows of drawn trajectories; the other arguments are those of `_means`."""
    members = np.split(np.argsort(group, kind="stable"), np.cumsum(np.bincount(group, minlength=count))[:-1])
    return np.array(
        [
            statistic(values[np.concatenate([members[index] for index in rng.integers(0, count, count)])])
            for _ in range(rounds)
        ]
    )
