"""Springs and sliders that pull as the gel does: a contact that slips at its rim before all of it slides."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import least_squares

Array = NDArray[np.float64]

PARTS = 12
"""Sliders side by side."""
LARGEST_FACTOR = 2.0
"""Of a spring over what a round contact of its area would have; its reciprocal is the smallest."""
STARTS = (0.0, 0.3, 0.6)
"""Spreads from which is searched."""
LEAST_PULL = 0.1
"""Of the limit: a touch that pulls less tells nothing of its springs."""


class Sliders(NamedTuple):
    """Equal springs side by side, each with a slider: Iwan's model of a contact that slips in part.

    Source: W. D. Iwan, J. Appl. Mech. 33 (1966), 893; limits that are spread evenly.

    Parameters
    ----------
    factor : float
        On the stiffness of a round contact, `tactiledata.effects.shear_stiffness`.
    spread : float
        Limits lie evenly within 1 - spread and 1 + spread of their mean: 0 where all slides at once.
    """

    factor: float = 1.0
    spread: float = 0.0

    def pull(self, path: Array, stiffness: Array, limit: Array) -> Array:
        """Pull (n, 2) on the gel along a path (n, 2), m; stiffness (n,) and limit (n,) are 0 without contact."""
        pull: Array = _followed(path, stiffness, limit, self.factor, self.spread)
        return pull


@njit(cache=True)
def _followed(path: Array, stiffness: Array, limit: Array, factor: float, spread: float) -> Array:
    count = PARTS if spread else 1
    held = np.zeros((count, 2))
    pull = np.zeros((len(limit), 2))
    for frame in range(len(limit)):
        if not limit[frame] > 0.0:
            held[:] = 0.0
            continue
        step_x, step_y = 0.0, 0.0
        if frame > 0:
            spring = 0.5 * factor * (stiffness[frame] + stiffness[frame - 1])
            step_x = (path[frame, 0] - path[frame - 1, 0]) * spring
            step_y = (path[frame, 1] - path[frame - 1, 1]) * spring
        for part in range(count):
            x, y = held[part, 0] + step_x / count, held[part, 1] + step_y / count
            size = np.sqrt(x * x + y * y)
            most = limit[frame] * (1.0 + spread * ((2.0 * part + 1.0) / PARTS - 1.0)) / count
            if size > most:
                x, y = x * most / size, y * most / size
            held[part, 0], held[part, 1] = x, y
            pull[frame, 0] += x
            pull[frame, 1] += y
    return pull


def own_sliders(path: Array, pull: Array, stiffness: Array, limit: Array) -> Sliders:
    """Those nearest to a pull (n, 2) along a path (n, 2), m; those of a round contact where it hardly pulls.

    Stiffness (n,) and limit (n,) as for `Sliders.pull`.
    """
    size = np.hypot(pull[:, 0], pull[:, 1])
    if size.max(initial=0.0) <= LEAST_PULL * limit.max(initial=0.0):
        return Sliders()
    # what slides on a curved gel is a little off the limit
    reached, unit = np.maximum(limit, np.where(limit > 0, size, 0.0)), size.max()

    def missing(values: Array) -> Array:
        sliders = Sliders(float(np.exp(values[0])), float(values[1]))
        return ((sliders.pull(path, stiffness, reached) - pull) / unit).ravel()

    most = float(np.log(LARGEST_FACTOR))
    start = min(([0.0, spread] for spread in STARTS), key=lambda one: float(np.sum(missing(np.array(one)) ** 2)))
    found = least_squares(missing, start, bounds=([-most, -1e-9], [most, 1.0]), diff_step=1e-2, max_nfev=20).x
    return Sliders(float(np.exp(found[0])), float(max(found[1], 0.0)))
