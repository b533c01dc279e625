"""Interpolation between design points at which the gel engine has played an effect."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactiledata.arrays import Array


def null_exact_weights(places: Sequence[float], value: float) -> Array:
    """Weights (k,) of the wrench differences at k design points for a value of the parameter.

    They are those of Lagrange's polynomial through the differences that is exactly 0 at the null, 0.

    Parameters
    ----------
    places : (k,)
        Design points, none of them 0, in the unit of the parameter.
    value : float
        Value of the parameter, in the same unit.
    """
    nodes = np.asarray(places, dtype=float)
    weights = value / nodes
    for index, node in enumerate(nodes):
        others = np.delete(nodes, index)
        weights[index] *= np.prod((value - others) / (node - others))
    return weights
