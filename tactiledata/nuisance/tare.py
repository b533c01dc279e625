"""The zero of the force sensor, which each trajectory takes from its own free air and knows only so well."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

MEDIAN_LOSS = np.pi / 2
"""Variance of a median over that of a mean, of Gaussian samples."""


def tare_variance(free_samples: Array) -> Array:
    """Variances (t,) of the zeros over that of one reading, each a median of so many samples in free air (t,)."""
    return MEDIAN_LOSS / np.maximum(free_samples, 1.0)


def without_tare(whitened: Array, starts: Indices, variance: Array, weights: Array) -> Array:
    """Whitened rows (n, k) with each trajectory's unknown zero marginalised: their squares sum to the likelihood's.

    A zero b ~ N(0, v) per component and trajectory, in rows of weight w, is the same as the covariance I + v w wᵀ over
    its rows; this multiplies by that matrix's inverse square root, which takes off a share of the rows' mean.

    Parameters
    ----------
    starts : (t,)
        First row of each trajectory, ascending.
    variance : (t,)
        Of the zero, over that of one reading.
    weights : (n,)
        With which the rows were multiplied.
    """
    counts = np.diff(starts, append=len(whitened))
    square = np.add.reduceat(weights**2, starts)
    share = 1.0 - 1.0 / np.sqrt(1.0 + square * variance)
    means = np.add.reduceat(whitened * weights[:, None], starts, axis=0) / square[:, None]
    return whitened - weights[:, None] * np.repeat(means * share[:, None], counts, axis=0)
