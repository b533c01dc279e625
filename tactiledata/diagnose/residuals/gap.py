"""How much of the way from the error before to the floor an explanation goes, with an interval over trajectories."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from tactiledata.arrays import Array

BOOTSTRAPS = 2000


def scatter(values: Array, starts: NDArray[np.int64]) -> float:
    """Root mean square of what residuals (n, k) do from frame to frame: a floor where the noise is not known.

    From second differences inside trajectories (Gasser, Sroka and Jennen-Steinmetz 1986), which smooth structure does
    not reach. Noise whose neighbours resemble one another is larger than this, so that gaps
    seem less closed than they are. NaN where no trajectory has three frames.
    """
    bends = values[2:] - 2.0 * values[1:-1] + values[:-2]
    trajectory = np.searchsorted(starts, np.arange(len(values)), side="right")
    inside = trajectory[2:] == trajectory[:-2]
    return float(np.sqrt(np.mean(bends[inside] ** 2) / 6.0)) if inside.any() else float("nan")


@dataclass(frozen=True)
class Gap:
    """Errors and the share of the gap that is closed.

    Parameters
    ----------
    before, after, floor : float
        Root mean squares.
    closed : float
        ``(before - after) / (before - floor)``; NaN where there is no gap.
    interval : (low, high)
        95 %, trajectories drawn anew.
    """

    before: float
    after: float
    floor: float
    closed: float
    interval: tuple[float, float]


def gap_closed(before: Array, after: Array, counts: Array, floor: float, seed: int = 0) -> Gap:
    """The gap closed by an explanation that was not chosen by these very frames.

    Parameters
    ----------
    before, after : (u,)
        Sums of squares of each unit of exchange.
    counts : (u,)
        Values that each sum holds.
    floor : float
        Root mean square that no explanation can go below.
    """
    units = len(counts)
    drawn = np.random.default_rng(seed).multinomial(units, np.full(units, 1.0 / units), size=BOOTSTRAPS)
    weights = np.concatenate([np.ones((1, units)), drawn.astype(np.float64)])
    total = weights @ counts
    first, second = np.sqrt(weights @ before / total), np.sqrt(weights @ after / total)
    room = first - floor
    closed = np.where(room > 0, (first - second) / np.where(room > 0, room, 1.0), np.nan)
    known = closed[1:][np.isfinite(closed[1:])]
    interval = tuple(float(end) for end in np.quantile(known, [0.025, 0.975])) if len(known) else (np.nan, np.nan)
    return Gap(float(first[0]), float(second[0]), floor, float(closed[0]), (interval[0], interval[1]))


def is_improved(before: Array, after: Array) -> bool:
    """Whether sums of squares (u,) of units of exchange are surely less after than before, at the 2.5 % level."""
    gained = before - after
    if not gained.any():
        return False
    error = float(gained.std(ddof=1)) / np.sqrt(len(gained))
    return float(gained.mean()) > float(student.ppf(0.975, len(gained) - 1)) * error
