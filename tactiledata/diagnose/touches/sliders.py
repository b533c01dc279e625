"""Springs with sliders side by side, which pull along a path as a contact does that slips part by part."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.optimize import least_squares

from tactiledata.arrays import Array

PARTS = 12
"""Number of sliders side by side."""
LARGEST_FACTOR = 2.0
"""Largest factor of a fitted stiffness on that of a round contact; its reciprocal is the smallest."""
STARTS = (0.0, 0.3, 0.6)
"""Spreads from which the best start of the fit is chosen."""
LEAST_PULL = 0.1
"""A touch whose largest pull is at most this share of the largest friction limit does not determine its springs."""


class Sliders(NamedTuple):
    """Equal springs side by side, each with a slider: Iwan's model of a contact that slips in part.

    Source: W. D. Iwan, J. Appl. Mech. 33 (1966), 893, with limits that are spread evenly.

    Parameters
    ----------
    factor : float
        Factor on the stiffness of a round contact, `tactiledata.effects.touch.shear_stiffness`.
    spread : float
        The limits lie evenly between 1 - spread and 1 + spread of their mean; at 0 all sliders slip at once.
    """

    factor: float = 1.0
    spread: float = 0.0

    def pull(self, path: Array, stiffness: Array, limit: Array) -> Array:
        """Return the pull (n, 2) on the gel along a path, in the unit of the limit.

        Parameters
        ----------
        path : (n, 2) m
            Position of the indenter along the gel.
        stiffness : (n,)
            Tangential stiffness of a round contact, in the unit of the limit per metre; 0 without contact.
        limit : (n,)
            Friction limit of the whole contact; 0 without contact.
        """
        pull: Array = _pull_of_sliders(path, stiffness, limit, self.factor, self.spread)
        return pull


@njit(cache=True)
def _pull_of_sliders(path: Array, stiffness: Array, limit: Array, factor: float, spread: float) -> Array:
    """Return the pull (n, 2) of springs with sliders along a path; see `Sliders.pull`."""
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
            # a spring that exceeds its limit slips back to it
            x, y = held[part, 0] + step_x / count, held[part, 1] + step_y / count
            size = np.sqrt(x * x + y * y)
            most = limit[frame] * (1.0 + spread * ((2.0 * part + 1.0) / PARTS - 1.0)) / count
            if size > most:
                x, y = x * most / size, y * most / size
            held[part, 0], held[part, 1] = x, y
            pull[frame, 0] += x
            pull[frame, 1] += y
    return pull


def own_sliders(path: Array, pulls: Array, stiffness: Array, limits: Array) -> Sliders:
    """Return the springs with sliders whose pulls are nearest to given ones; those of a round contact if all are faint.

    Parameters
    ----------
    path : (n, 2) m
        Position of the indenter along the gel.
    pulls : (m, n, 2)
        Pull on the gel at each of m friction coefficients.
    stiffness : (n,)
        As in `Sliders.pull`, in the unit of the pull.
    limits : (m, n)
        Friction limit at each of the coefficients.
    """
    sizes = np.hypot(pulls[..., 0], pulls[..., 1])
    if sizes.max(initial=0.0) <= LEAST_PULL * limits.max(initial=0.0):
        return Sliders()
    unit = sizes.max()

    def missing(values: Array) -> Array:
        sliders = Sliders(float(np.exp(values[0])), float(values[1]))
        found = np.array([sliders.pull(path, stiffness, limit) for limit in limits])
        return ((found - pulls) / unit).ravel()

    most = float(np.log(LARGEST_FACTOR))
    start = min(([0.0, spread] for spread in STARTS), key=lambda values: float(np.sum(missing(np.array(values)) ** 2)))
    solution = least_squares(missing, start, bounds=([-most, -1e-9], [most, 1.0]), diff_step=1e-2, max_nfev=20).x
    return Sliders(float(np.exp(solution[0])), float(max(solution[1], 0.0)))
