"""Instruments: functions of a covariate or label along which a parameter may vary (steps, a slope, levels)."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.residuals import Names

DECILES = np.arange(1, 10) / 10
"""Quantiles of a covariate at which steps are tried."""
WIDE = 5.0
"""Ratio of the 95 % to the 5 % quantile above which the scale of a positive covariate is logarithmic."""
LOW, HIGH = 0.05, 0.95
"""Quantiles of a covariate between which a slope rises from 0 to 1."""
MOST_LEVELS = 40
"""Most different texts of a label that is tested; a label with more is ignored."""


def weighed_quantiles(values: Array, weights: Array, shares: Array) -> Array:
    """Return the weighted quantiles (q,) of a covariate.

    Parameters
    ----------
    values, weights : (n,)
        Values and their non-negative weights.
    shares : (q,)
        Cumulative shares of the weight, 0 to 1.
    """
    order = np.argsort(values, kind="stable")
    cumulative = np.cumsum(weights[order])
    places = np.searchsorted(cumulative, shares * cumulative[-1])
    return values[order][np.minimum(places, len(values) - 1)]


def cuts(values: Array, weights: Array) -> Array:
    """Return values (c,) of a covariate at which a step is tried: its deciles; empty where no frame has a weight.

    Parameters
    ----------
    values, weights : (n,)
        The covariate, and the information of each frame on the parameter; frames without information weigh 0.
    """
    if not weights.sum() > 0:
        return np.zeros(0)
    places = np.unique(weighed_quantiles(values, weights, DECILES))
    informed = values[weights > 0]
    return places[places < informed.max()]


def steps(values: Array, places: Array) -> Array:
    """Return the step instruments (n, c): 1 where a covariate (n,) lies above each of the places (c,), else 0."""
    return (values[:, None] > places).astype(np.float64)


def is_logarithmic(values: Array) -> bool:
    """Return whether a covariate (n,) is positive and its 5 % and 95 % quantiles are a factor `WIDE` apart."""
    if not (values > 0).all():
        return False
    low, high = np.quantile(values, [LOW, HIGH])
    return bool(high > WIDE * low)


def slope(values: Array, weights: Array) -> tuple[Array, float, float]:
    """Return an instrument (n, 1), linear in a covariate or its logarithm, and the values where it is 0 and 1.

    These values are the weighted 5 % and 95 % quantiles. The instrument is 0 everywhere where both are equal.

    Parameters
    ----------
    values, weights : (n,)
        The covariate, and the information of each frame on the parameter.
    """
    low, high = weighed_quantiles(values, weights, np.array([LOW, HIGH]))
    scale = np.log if is_logarithmic(values[weights > 0]) and (values > 0).all() else np.asarray
    ends = scale(np.array([low, high]))
    if not ends[1] > ends[0]:
        return np.zeros((len(values), 1)), float(low), float(high)
    return ((scale(values) - ends[0]) / (ends[1] - ends[0]))[:, None], float(low), float(high)


def levels(texts: Names) -> tuple[list[str], Array]:
    """Return the levels of a label (n,), and indicator instruments (n, c); none where it has one level or too many."""
    names, inverse = np.unique(texts, return_inverse=True)
    if not 2 <= len(names) <= MOST_LEVELS:
        return [], np.zeros((len(texts), 0))
    kept = [str(name) for name in names]
    return kept, (inverse[:, None] == np.arange(len(names))).astype(np.float64)
