"""Effects that the gel engine plays: a few design points beforehand, a polynomial between them ever after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tactiledata.effects.response import BaseResponse, GelVariant

Array = NDArray[np.float64]

Designs = Mapping[str, tuple[tuple[float, GelVariant], ...]]
"""By parameter: values other than the null, and the gel that each stands for."""


def designed_difference(designs: Designs, values: Mapping[str, float], base: BaseResponse) -> Array | None:
    """What the variants add to the wrench (n, 6): each parameter's own polynomial, summed; ``None`` where nothing.

    The null is 0 of every parameter, where the polynomial is exactly 0. Parameters are taken as independent: their
    products are not played.
    """
    total: Array | None = None
    for name, points in designs.items():
        value = values[name]
        if value == 0.0:
            continue
        weights = null_exact_weights([place for place, _ in points], value)
        for weight, (_, variant) in zip(weights, points, strict=True):
            part = weight * base.difference(variant)
            total = part if total is None else total + part
    return total


def null_exact_weights(places: Sequence[float], value: float) -> Array:
    """Weights (k,) of differences at ``places``: Lagrange's polynomial that is 0 at 0 and has the differences there."""
    nodes = np.asarray(places, dtype=float)
    weights = value / nodes
    for number, node in enumerate(nodes):
        others = np.delete(nodes, number)
        weights[number] *= np.prod((value - others) / (node - others))
    return weights
