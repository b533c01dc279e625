"""The loss around its optimum, over two parameters."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array
from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.losses import Loss

POINTS = 25


def loss_surface(
    loss: Loss, bounds: Bounds, optimum: Array, across: int, up: int, points: int = POINTS
) -> tuple[Array, Array, Array]:
    """Places x (p,), y (p,) and the loss (p, p), rows over ``up``; the third parameter stays at its optimum.

    Parameters
    ----------
    across, up : places of the parameters: 0 E, 1 nu, 2 mu
    """
    x = np.linspace(bounds.low[across], bounds.high[across], points)
    y = np.linspace(bounds.low[up], bounds.high[up], points)
    values = np.empty((points, points))
    for row, column in np.ndindex(points, points):
        place = optimum.copy()
        place[across], place[up] = x[column], y[row]
        values[row, column] = loss.value(place)
    return x, y, values
