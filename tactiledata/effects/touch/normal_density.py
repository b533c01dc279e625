"""Density of the normal distribution of mean 0 and standard deviation 1."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array


def normal_density(z: Array) -> Array:
    """Density phi(z) = exp(-z^2 / 2) / sqrt(2 pi) of the standard normal distribution, shaped as z."""
    return np.asarray(np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi))
