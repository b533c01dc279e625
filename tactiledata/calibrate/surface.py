"""Values of a loss around its optimum, over two of the three parameters."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array
from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.losses import Loss

POINTS = 25
"""Points of the grid along each parameter."""


def loss_surface(
    loss: Loss, bounds: Bounds, optimum: Array, across: int, up: int, points: int = POINTS
) -> tuple[Array, Array, Array]:
    """Return grids x (p,) and y (p,) over the box, and the loss (p, p) with rows over y.

    The third parameter stays at its optimum.

    Parameters
    ----------
    loss : Loss
        Evaluated at all p * p points.
    bounds : Bounds
        The box that is covered.
    optimum : (3,)
        E (Pa), nu, mu.
    across, up : int
        Places of the parameters on the x and y axes: 0 E, 1 nu, 2 mu.
    points : int
        Points p along each axis.
    """
    x = np.linspace(bounds.low[across], bounds.high[across], points)
    y = np.linspace(bounds.low[up], bounds.high[up], points)
    values = np.empty((points, points))
    for row, column in np.ndindex(points, points):
        place = optimum.copy()
        place[across], place[up] = x[column], y[row]
        values[row, column] = loss.value(place)
    return x, y, values
