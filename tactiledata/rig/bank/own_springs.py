"""Springs and sliders that pull as a solved contact does: what closed forms know only roughly, taken from it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from tactiledata.arrays import RealArray
from tactiledata.rig.contact.contact import CONTACT_RATE
from tactiledata.rig.hidden.coulomb_limit import beyond_coulomb
from tactiledata.rig.hidden.slider import slide

WAY = 2e-5
"""m along the gel and into it between the moments at which pulls are compared."""
LARGEST_FACTOR = 2.0
"""And the reciprocal of the smallest."""
STARTS = (0.0, 0.3, 0.6)
"""Spreads from which is searched."""


class OwnSprings(NamedTuple):
    """How a contact pulls along the gel.

    Parameters
    ----------
    factor : float
        On the closed form's stiffness along the gel.
    spread : float
        See `slide`: 0 where all of the contact slides at once, more where its rim slides before.
    """

    factor: float = 1.0
    spread: float = 0.0

    def pull(self, path: RealArray, normal: RealArray, stiffness: RealArray, friction: float) -> RealArray:
        """Pull (n, 2), N, on the gel; see `slide`."""
        told = np.column_stack([path, normal, stiffness])
        changes = np.append(True, (np.diff(told, axis=0) != 0).any(axis=1))
        x, y, force, spring = told[changes].T
        way, areas = np.column_stack([x, y]), np.ones(len(x))  # areas matter only to friction by pressure
        pull = slide(way, force, self.factor * spring, areas, friction, CONTACT_RATE, (), self.spread)[0]
        return pull[np.cumsum(changes) - 1]


def own_springs(
    path: RealArray, normal: RealArray, stiffness: RealArray, friction: float, pull: RealArray
) -> OwnSprings:
    """Those nearest to a contact's own pull (n, 2), N; those of the closed form where it hardly pulls.

    Parameters
    ----------
    path : (n, 3), m
        x, y and depth.
    normal : (n,), N
    stiffness : (n,), N/m
        The closed form's.
    friction : float
    """
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    rows = np.unique(np.searchsorted(travelled, np.arange(0.0, travelled[-1], WAY)))
    limit = friction * normal[rows]
    if np.linalg.norm(pull[rows], axis=1).max(initial=0.0) < 0.1 * limit.max(initial=0.0):
        return OwnSprings()
    reached = limit * beyond_coulomb(pull[rows], limit) / friction

    def missing(values: RealArray) -> RealArray:
        springs = OwnSprings(float(np.exp(values[0])), float(values[1]))
        found = springs.pull(path[rows, :2], reached, stiffness[rows], friction)
        return (found - pull[rows]).ravel()

    most = float(np.log(LARGEST_FACTOR))
    start = min(([0.0, spread] for spread in STARTS), key=lambda one: float(np.sum(missing(np.array(one)) ** 2)))
    found = least_squares(missing, start, bounds=([-most, -1e-9], [most, 1.0]), diff_step=1e-2, max_nfev=8)
    return OwnSprings(float(np.exp(found.x[0])), float(max(found.x[1], 0.0)))
