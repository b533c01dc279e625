"""The density of a normal distribution of mean 0 and deviation 1."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array


def normal_density(z: Array) -> Array:
    """phi(z) = exp(-z^2 / 2) / sqrt(2 pi)."""
    return np.asarray(np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi))
