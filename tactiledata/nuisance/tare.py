"""The zero of the force sensor, which each trajectory takes from its own free air and knows only so well."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array, Indices

MEDIAN_LOSS = np.pi / 2
"""Variance of a median over that of a mean, of Gaussian samples."""


def tare_variance(free_samples: Array, reading_variance: Array | float = 1.0) -> Array:
    """Return variances (t,) of the zeros, over that of a wrench at a frame.

    Parameters
    ----------
    free_samples : (t,)
        Readings in free air whose median each zero is.
    reading_variance : float or (t,)
        Variance of a reading over that of a wrench at a frame.
    """
    return MEDIAN_LOSS * np.asarray(reading_variance) / np.maximum(free_samples, 1.0)


def without_tare(whitened: Array, starts: Indices, variance: Array, weights: Array) -> Array:
    """Whitened rows (n, k) with each trajectory's unknown zero marginalised: their squares sum to the likelihood's.

    A zero b ~ N(0, v) per component and trajectory, in rows of weight w, is the same as the covariance I + v w wᵀ over
    its rows; this multiplies by that matrix's inverse square root, which takes off a share of the rows' mean.

    Parameters
    ----------
    starts : (t,)
        First row of each trajectory, ascending.
    variance : (t,)
        Of the zero, over that of a wrench at a frame.
    weights : (n,)
        With which the rows were multiplied.
    """
    counts = np.diff(starts, append=len(whitened))
    square = np.add.reduceat(weights**2, starts)
    share = 1.0 - 1.0 / np.sqrt(1.0 + square * variance)
    means = np.add.reduceat(whitened * weights[:, None], starts, axis=0) / square[:, None]
    return whitened - weights[:, None] * np.repeat(means * share[:, None], counts, axis=0)


def zero_power(rows: Array, gains: Array, starts: Indices, variance: Array, power: float) -> Array:
    """Rows (n, k, c) times a power of the covariance that an unknown zero gives them, where rows differ in noise.

    A zero b ~ N(0, v I), in units of the noise, is G b in the rows of a trajectory: their covariance is I + v G Gᵀ.
    Power -1/2 marginalises it, as `without_tare` does; 1/2 undoes that.

    Parameters
    ----------
    gains : (n, k, k)
        G, symmetric: the identity where noise is all there is.
    starts, variance : (t,)
        As in `without_tare`.
    """
    counts = np.diff(starts, append=len(rows))
    values, axes = np.linalg.eigh(np.add.reduceat(gains @ gains, starts))
    small = 1e-12 * np.maximum(values.max(axis=1, keepdims=True), 1e-300)
    size = np.maximum(values, small)
    scale = ((1.0 + variance[:, None] * size) ** power - 1.0) / size
    core = (axes * scale[:, None, :]) @ axes.transpose(0, 2, 1)
    told = np.add.reduceat(gains @ rows, starts)
    changed: Array = rows + gains @ np.repeat(core @ told, counts, axis=0)
    return changed
