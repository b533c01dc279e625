"""Statistics of columns that grow with their store: each value is seen once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Statistics = dict[str, list[Any]]

LARGEST = float(np.finfo(np.float64).max)


def no_statistics(width: int) -> Statistics:
    """Statistics of columns without values."""
    return {"count": [0] * width, **{name: [0.0] * width for name in ("mean", "m2", "min", "max")}}


def added(before: Mapping[str, Any], values: NDArray[np.float64]) -> Statistics:
    """Statistics after more rows (n, k); values that are not finite do not count.

    Source: Chan, Golub and LeVeque 1983, the pairwise update of mean and sum of squared deviations.

    Examples
    --------
    >>> added(no_statistics(1), np.array([[1.0], [3.0], [np.nan]]))
    {'count': [2], 'mean': [2.0], 'm2': [2.0], 'min': [1.0], 'max': [3.0]}
    """
    finite = np.isfinite(values)
    n_new = finite.sum(axis=0)
    n_old = np.array(before["count"])
    n_all = n_old + n_new
    with np.errstate(all="ignore"):
        kept = np.where(finite, values, 0.0)
        mean_new = kept.sum(axis=0) / np.maximum(n_new, 1)
        m2_new = (np.where(finite, values - mean_new, 0.0) ** 2).sum(axis=0)
        step = mean_new - np.array(before["mean"])
        share = n_new / np.maximum(n_all, 1)
        mean = np.array(before["mean"]) + step * share
        m2 = np.array(before["m2"]) + m2_new + step**2 * n_old * share
    low = np.where(finite, values, np.inf).min(axis=0, initial=np.inf)
    high = np.where(finite, values, -np.inf).max(axis=0, initial=-np.inf)
    low = np.where(n_old > 0, np.minimum(low, before["min"]), np.where(n_new > 0, low, 0.0))
    high = np.where(n_old > 0, np.maximum(high, before["max"]), np.where(n_new > 0, high, 0.0))
    return {
        "count": n_all.tolist(),
        "mean": _bounded(mean),
        "m2": _bounded(m2),
        "min": _bounded(low),
        "max": _bounded(high),
    }


def _bounded(values: NDArray[np.float64]) -> list[float]:
    return np.nan_to_num(values, nan=LARGEST, posinf=LARGEST, neginf=-LARGEST).tolist()


def statistics_fault(statistics: Mapping[str, Any], width: int) -> str:
    """What cannot be right in the statistics of so many columns; empty where all can.

    Examples
    --------
    >>> statistics_fault({"count": [1], "mean": [0.0], "m2": [-1.0], "min": [0.0], "max": [0.0]}, 1)
    'have squares of deviations below zero'
    """
    if any(len(statistics[name]) != width for name in no_statistics(0)):
        return f"have not {width} entries each, one a column"
    count, mean, m2, low, high = (np.array(statistics[name], dtype=float) for name in no_statistics(0))
    if not np.isfinite([count, mean, m2, low, high]).all():
        return "are not finite"
    if (m2 < 0).any():
        return "have squares of deviations below zero"
    if (low > high).any():
        return "have a least value above the largest"
    return ""


def standard_deviation(statistics: Mapping[str, Any]) -> list[float]:
    """Standard deviation of each column; 0 where it has no values."""
    return [float(np.sqrt(m2 / max(count, 1))) for m2, count in zip(statistics["m2"], statistics["count"], strict=True)]
