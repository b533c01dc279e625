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


def zero_power(rows: Array, gains: Array, starts: Indices, variance: Array, power: float) -> Array:
    """Multiply rows (n, k, c) by a power of the covariance that an unknown zero gives them, where rows differ in noise.

    A zero b ~ N(0, v I), in units of the noise, is G b in the rows of a trajectory: their covariance is I + v G Gᵀ.
    Power -1/2 marginalises the zero, as `without_tare` does; power 1/2 undoes that.

    Parameters
    ----------
    rows : (n, k, c)
        Whitened wrenches of k components, c columns side by side.
    gains : (n, k, k)
        G of each row, symmetric; the identity where the noise of the zero is that of the row.
    starts : (t,)
        First row of each trajectory, ascending.
    variance : (t,)
        Variance of the zero, over that of a wrench at a frame.
    power : float
        Exponent of the covariance.
    """
    counts = np.diff(starts, append=len(rows))
    values, axes = np.linalg.eigh(np.add.reduceat(gains @ gains, starts))
    floor = 1e-12 * np.maximum(values.max(axis=1, keepdims=True), 1e-300)
    eigenvalues = np.maximum(values, floor)
    # (I + v G Gᵀ)^p = I + G core Gᵀ, with the eigenvectors of Gᵀ G
    scale = ((1.0 + variance[:, None] * eigenvalues) ** power - 1.0) / eigenvalues
    core = (axes * scale[:, None, :]) @ axes.transpose(0, 2, 1)
    sums = np.add.reduceat(gains @ rows, starts)
    changed: Array = rows + gains @ np.repeat(core @ sums, counts, axis=0)
    return changed
