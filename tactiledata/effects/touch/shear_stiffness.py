"""Tangential stiffness of a contact that sticks."""

from __future__ import annotations

import numpy as np
from numba import njit

from tactiledata.arrays import Array


@njit(cache=True)
def shear_stiffness(area: Array, poisson_ratio: float, thickness: float) -> Array:
    """Tangential stiffness (n,), over Young's modulus, m, of round contacts on a bonded layer.

    A half-space (Mindlin: 8 G a / (2 - nu)) and a thin layer (G A / h) in parallel, each right in its own limit.

    Parameters
    ----------
    area : (n,) m^2
        Areas of the contacts.
    poisson_ratio : float
        Of the gel.
    thickness : float
        Height of the layer, m.
    """
    modulus = 0.5 / (1.0 + poisson_ratio)
    stiffness: Array = 8.0 * modulus * np.sqrt(area / np.pi) / (2.0 - poisson_ratio) + modulus * area / thickness
    return stiffness
