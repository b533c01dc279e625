"""Permutation p-values from random signs of whole units of exchange, alone or for a family of tests."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array

DRAWS = 1999
"""Sign vectors of a test: the smallest p-value is 1 / 2000."""


def signs(units: int, draws: int, seed: int) -> Array:
    """Return random signs (draws, units), each -1 or 1 with equal probability.

    Parameters
    ----------
    units : int
        Number of units of exchange.
    draws : int
        Number of sign vectors.
    seed : int
        Random seed.
    """
    return np.random.default_rng(seed).integers(0, 2, (draws, units)).astype(np.float64) * 2.0 - 1.0


def p_value(observed: float, drawn: Array) -> float:
    """Return the share of drawn statistics (draws,) at least as large as the observed one, which counts itself."""
    return float((1 + np.count_nonzero(drawn >= observed)) / (1 + len(drawn)))


def family_wise(observed: Array, drawn: Array) -> Array:
    """Return the family-wise p-values (m,) of m statistics: the step-down maximum of Westfall and Young.

    Parameters
    ----------
    observed : (m,)
        Statistics of the data; larger is more extreme.
    drawn : (draws, m)
        Statistics after sign flips; all of a row share their signs, which keeps the correlation of the tests.
    """
    order = np.argsort(-observed, kind="stable")
    # column j: maximum over the statistics that rank at or below place j
    highest = np.maximum.accumulate(drawn[:, order[::-1]], axis=1)[:, ::-1]
    exceeding = np.count_nonzero(highest >= observed[order] - 1e-12, axis=0)
    stepped = np.maximum.accumulate((1 + exceeding) / (1 + len(drawn)))
    values = np.empty(len(observed))
    values[order] = stepped
    return values


def holm(p_values: Array) -> Array:
    """Return Holm's family-wise p-values (m,) of m p-values, valid for tests of any dependence."""
    count = len(p_values)
    order = np.argsort(p_values, kind="stable")
    stepped = np.maximum.accumulate((count - np.arange(count)) * p_values[order])
    values = np.empty(count)
    values[order] = np.minimum(stepped, 1.0)
    return values
