"""How stiff a contact that sticks is along the gel."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array


def shear_stiffness(area: Array, poisson_ratio: float, thickness: float) -> Array:
    """Tangential stiffness (n,), m, over Young's modulus, of round contacts (n,), m^2, on a bonded layer.

    A half-space (Mindlin: 8 G a / (2 - nu)) and a thin layer (G A / h) side by side, each right in its own limit.
    """
    modulus = 0.5 / (1.0 + poisson_ratio)
    stiffness: Array = 8.0 * modulus * np.sqrt(area / np.pi) / (2.0 - poisson_ratio) + modulus * area / thickness
    return stiffness
