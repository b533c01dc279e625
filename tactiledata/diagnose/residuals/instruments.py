"""Instruments by which a parameter may vary with a covariate: steps at its quantiles, a slope, levels of a label."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.residuals import Names

DECILES = np.arange(1, 10) / 10
WIDE = 5.0
"""Factor between the 5 % and 95 % quantiles of a positive covariate from which on its scale is logarithmic."""
LOW, HIGH = 0.05, 0.95
MOST_LEVELS = 40


def weighed_quantiles(values: Array, weights: Array, shares: Array) -> Array:
    """Quantiles of values (n,) that count with weights (n,)."""
    order = np.argsort(values, kind="stable")
    cumulative = np.cumsum(weights[order])
    places = np.searchsorted(cumulative, shares * cumulative[-1])
    return values[order][np.minimum(places, len(values) - 1)]


def cuts(values: Array, weights: Array) -> Array:
    """Places (c,) at which a step is tried; none where the values hardly vary.

    Parameters
    ----------
    values, weights : (n,)
        Frames that say nothing of the parameter weigh 0.
    """
    if not weights.sum() > 0:
        return np.zeros(0)
    places = np.unique(weighed_quantiles(values, weights, DECILES))
    informed = values[weights > 0]
    return places[places < informed.max()]


def steps(values: Array, places: Array) -> Array:
    """Instruments (n, c): 1 above each place."""
    return (values[:, None] > places).astype(np.float64)


def is_logarithmic(values: Array) -> bool:
    """Whether a covariate's natural scale is its logarithm."""
    if not (values > 0).all():
        return False
    low, high = np.quantile(values, [LOW, HIGH])
    return bool(high > WIDE * low)


def slope(values: Array, weights: Array) -> tuple[Array, float, float]:
    """An instrument (n, 1) that goes from 0 to 1 between two values of the covariate, and those values.

    It is 0 where most of the frames that say anything have one value.
    """
    low, high = weighed_quantiles(values, weights, np.array([LOW, HIGH]))
    scale = np.log if is_logarithmic(values[weights > 0]) and (values > 0).all() else np.asarray
    ends = scale(np.array([low, high]))
    if not ends[1] > ends[0]:
        return np.zeros((len(values), 1)), float(low), float(high)
    return ((scale(values) - ends[0]) / (ends[1] - ends[0]))[:, None], float(low), float(high)


def levels(texts: Names) -> tuple[list[str], Array]:
    """The levels of a label and an instrument (n, c) for each; none where there is one, or too many to say."""
    names, inverse = np.unique(texts, return_inverse=True)
    if not 2 <= len(names) <= MOST_LEVELS:
        return [], np.zeros((len(texts), 0))
    kept = [str(name) for name in names]
    return kept, (inverse[:, None] == np.arange(len(names))).astype(np.float64)
