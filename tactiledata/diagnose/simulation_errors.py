"""How much contrasts scatter where nothing is missing: what a simulation of a gel may itself be off."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

Array = NDArray[np.float64]

OF_THE_GEL: Mapping[str, float] = {
    "fx": 0.011, "fy": 0.011, "fz": 0.25, "tx": 0.0, "ty": 0.0, "tz": 0.038,
    "shear along the slide": 0.028, "torque of shear along the slide": 0.35,
    "E": 0.013, "nu": 0.01, "mu": 0.03, "contact offset": 0.0025,
}  # fmt: skip
"""Standard deviations of contrasts, as in `Contrast`: times the noise, shares of E, nu and mu, mm. Where two solvers of
one gel play the same touches: ``python benchmarks/locating_worlds.py --mounts 12 --errors 30``."""


def scatter_beyond_noise(sizes: Array, variances: Array) -> float:
    """The e for which sizes (c,) have a mean square of 1 over their variance by noise (c,) and e^2; 0 where noise does.

    Source: the moment estimator of a variance component (Paule and Mandel, J. Res. NBS 87, 1982).
    """

    def excess(e: float) -> float:
        return float(np.mean(sizes**2 / (variances + e**2))) - 1.0

    if not len(sizes) or excess(0.0) <= 0:
        return 0.0
    return float(brentq(excess, 0.0, float(np.abs(sizes).max())))
