"""The share of the gap between error and noise floor that a correction closes, with an interval over trajectories."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from tactiledata.arrays import Array

BOOTSTRAPS = 2000
"""Bootstrap samples of the interval of a gap."""


def scatter(values: Array, starts: NDArray[np.int64]) -> float:
    """Return the root mean square of the frame-to-frame noise of residuals (n, k): a floor without stated noise.

    The estimate uses second differences inside trajectories (Gasser, Sroka and Jennen-Steinmetz 1986), which smooth
    structure does not affect. It is too small where the noise of neighbouring frames is positively correlated; the
    closed share of a gap is then underestimated. NaN where no trajectory has three frames.

    Parameters
    ----------
    values : (n, k)
        Residuals; the result has their unit.
    starts : (t,)
        First row of each trajectory.
    """
    bends = values[2:] - 2.0 * values[1:-1] + values[:-2]
    trajectory = np.searchsorted(starts, np.arange(len(values)), side="right")
    inside = trajectory[2:] == trajectory[:-2]
    return float(np.sqrt(np.mean(bends[inside] ** 2) / 6.0)) if inside.any() else float("nan")


@dataclass(frozen=True)
class Gap:
    """Errors before and after a correction, and the share of the gap to the noise floor that it closes.

    Parameters
    ----------
    before, after, floor : float
        Root mean square errors, all in the unit of the residuals; the floor is the noise.
    closed : float
        ``(before - after) / (before - floor)``; NaN where there is no gap.
    interval : (low, high)
        95 % interval of ``closed``, by a bootstrap over units of exchange.
    """

    before: float
    after: float
    floor: float
    closed: float
    interval: tuple[float, float]


def gap_closed(before: Array, after: Array, counts: Array, floor: float, seed: int = 0) -> Gap:
    """Return the share of the gap that a correction closes, on frames that had no part in choosing it.

    Parameters
    ----------
    before, after : (u,)
        Sum of squared residuals of each unit of exchange, without and with the correction.
    counts : (u,)
        Number of values in each sum.
    floor : float
        Root mean square of the noise, below which no correction can go.
    seed : int
        Random seed of the bootstrap.
    """
    units = len(counts)
    drawn = np.random.default_rng(seed).multinomial(units, np.full(units, 1.0 / units), size=BOOTSTRAPS)
    # row 0 is the data themselves, the others are bootstrap samples
    weights = np.concatenate([np.ones((1, units)), drawn.astype(np.float64)])
    total = weights @ counts
    first, second = np.sqrt(weights @ before / total), np.sqrt(weights @ after / total)
    room = first - floor
    closed = np.where(room > 0, (first - second) / np.where(room > 0, room, 1.0), np.nan)
    known = closed[1:][np.isfinite(closed[1:])]
    interval = tuple(float(end) for end in np.quantile(known, [0.025, 0.975])) if len(known) else (np.nan, np.nan)
    return Gap(float(first[0]), float(second[0]), floor, float(closed[0]), (interval[0], interval[1]))


def is_improved(before: Array, after: Array) -> bool:
    """Return whether a correction lowers the squared residuals for certain.

    The test is a one-sided t-test at 2.5 % that the mean fall over the units of exchange is above 0; at least two units
    are needed.

    Parameters
    ----------
    before, after : (u,)
        Sum of squared residuals of each unit of exchange, without and with the correction.
    """
    gained = before - after
    if not gained.any():
        return False
    error = float(gained.std(ddof=1)) / np.sqrt(len(gained))
    return float(gained.mean()) > float(student.ppf(0.975, len(gained) - 1)) * error
