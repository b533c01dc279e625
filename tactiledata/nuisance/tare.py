"""Uncertainty of the force sensor's zero, which each trajectory takes from its own readings in free air."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array, Indices

MEDIAN_LOSS = np.pi / 2
"""Variance of the median of Gaussian samples over that of their mean."""


def tare_variance(free_samples: Array, reading_variance: Array | float = 1.0) -> Array:
    """Return the variance (t,) of each trajectory's zero, over that of a wrench at a frame.

    Parameters
    ----------
    free_samples : (t,)
        Number of readings in free air whose median each zero is.
    reading_variance : float or (t,)
        Variance of a reading over that of a wrench at a frame.
    """
    return MEDIAN_LOSS * np.asarray(reading_variance) / np.maximum(free_samples, 1.0)


def without_tare(whitened: Array, starts: Indices, variance: Array, weights: Array) -> Array:
    """Marginalise each trajectory's unknown zero in whitened rows (n, k).

    The squares of the rows returned sum to the deviance. A zero b ~ N(0, v) per component and trajectory, in rows of
    weight w, is the same as the covariance I + v w wᵀ over its rows. Multiplying by that matrix's inverse square root
    subtracts a share of the rows' mean.

    Parameters
    ----------
    whitened : (n, k)
        Whitened wrenches, multiplied by their weights.
    starts : (t,)
        First row of each trajectory, ascending.
    variance : (t,)
        Variance of the zero, over that of a wrench at a frame.
    weights : (n,)
        Weights by which the rows were multiplied.
    """
    counts = np.diff(starts, append=len(whitened))
    square = np.add.reduceat(weights**2, starts)
    share = 1.0 - 1.0 / np.sqrt(1.0 + square * variance)
    means = np.add.reduceat(whitened * weights[:, None], starts, axis=0) / square[:, None]
    return whitened - weights[:, None] * np.repeat(means * share[:, None], counts, axis=0)
