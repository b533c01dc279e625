"""Signs of whole trajectories thrown anew: the only chance that the tests here rest on."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array

DRAWS = 1999


def signs(units: int, draws: int, seed: int) -> Array:
    """Random signs (draws, units) of the units of exchange."""
    return np.random.default_rng(seed).integers(0, 2, (draws, units)).astype(np.float64) * 2.0 - 1.0


def p_value(observed: float, drawn: Array) -> float:
    """Share of statistics at least as large, the observed one counted among them."""
    return float((1 + np.count_nonzero(drawn >= observed)) / (1 + len(drawn)))


def family_wise(observed: Array, drawn: Array) -> Array:
    """p-values (m,) that hold for all m statistics together: the step-down maximum of Westfall and Young.

    Parameters
    ----------
    observed : (m,)
    drawn : (draws, m)
        Of the same signs in each row, so that what hangs together stays together.
    """
    order = np.argsort(-observed, kind="stable")
    highest = np.maximum.accumulate(drawn[:, order[::-1]], axis=1)[:, ::-1]
    exceeding = np.count_nonzero(highest >= observed[order] - 1e-12, axis=0)
    stepped = np.maximum.accumulate((1 + exceeding) / (1 + len(drawn)))
    values = np.empty(len(observed))
    values[order] = stepped
    return values


def holm(p_values: Array) -> Array:
    """Holm's p-values (m,) of m tests of any dependence."""
    count = len(p_values)
    order = np.argsort(p_values, kind="stable")
    stepped = np.maximum.accumulate((count - np.arange(count)) * p_values[order])
    values = np.empty(count)
    values[order] = np.minimum(stepped, 1.0)
    return values
