"""Effects that the gel engine plays: a few design points beforehand, a polynomial between them ever after."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactiledata.arrays import Array


def null_exact_weights(places: Sequence[float], value: float) -> Array:
    """Weights (k,) of differences at ``places``: Lagrange's polynomial that is 0 at 0 and has the differences there."""
    nodes = np.asarray(places, dtype=float)
    weights = value / nodes
    for number, node in enumerate(nodes):
        others = np.delete(nodes, number)
        weights[number] *= np.prod((value - others) / (node - others))
    return weights
