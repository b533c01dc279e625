"""Springs and sliders that are fitted to a contact: they pull along the gel as it does.

The contact of a solver slips at its rim before all of it slides. What a hidden effect or another way along the gel
changes is told by these springs, with the change less without it.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from tactiledata.arrays import RealArray
from tactiledata.rig.contact.closed_form import stick_slip
from tactiledata.rig.contact.contact import CONTACT_RATE
from tactiledata.rig.hidden.coulomb_limit import beyond_coulomb
from tactiledata.rig.hidden.slider import Loaded, SlidingLaws, slide

COMPARED_EVERY = 2e-5
"""Travel of the indenter, m, between the moments at which pulls are compared."""
LARGEST_FACTOR = 2.0
"""Largest factor on the closed form's stiffness; the smallest is its reciprocal."""
STARTS = (0.3, 0.6)
"""Spreads among which the fit picks its start: from 0 there is no way on, since limits that are all alike stay so."""
SAME = 1e-6
"""Share of the largest pull within which a contact is that of the closed forms."""


class OwnSprings(NamedTuple):
    """Springs and sliders of one contact along the gel.

    Parameters
    ----------
    factor : float
        Multiplies the closed form's stiffness along the gel.
    spread : float
        Spread of the sliders' limits, see `relative_limits`: 0 where all of the contact slides at once.
    """

    factor: float = 1.0
    spread: float = 0.0

    def pull(self, path: RealArray, loaded: Loaded, friction: float) -> RealArray:
        """Return the pull (n, 2), N, of the indenter on the gel.

        Parameters
        ----------
        path : (n, 2), m
            Places of the indenter along the gel.
        loaded : Loaded
            Normal force, and the closed form's stiffness along the gel.
        friction : float
            Coulomb's coefficient.
        """
        if self.spread <= 0:
            return stick_slip(path, loaded.normal, self.factor * loaded.stiffness, friction)[0]
        # moments at which nothing changes are left out, since the result is the same
        rows = np.column_stack([path, *loaded])
        changes = np.append(True, (np.diff(rows, axis=0) != 0).any(axis=1))
        x, y, force, spring = rows[changes].T
        areas = np.ones(len(x))  # they matter only to friction by pressure
        parts, laws = Loaded(force, self.factor * spring), SlidingLaws(spreads=[self.spread])
        pull = slide(np.column_stack([x, y]), parts, areas, friction, CONTACT_RATE, laws)[0]
        return pull[np.cumsum(changes) - 1]


class Pulled(NamedTuple):
    """What a contact pulls along one path, at one friction.

    Parameters
    ----------
    friction : float
        Coulomb's coefficient.
    normal : (n,), N
        Normal force.
    pull : (n, 2), N
        Pull on the gel.
    """

    friction: float
    normal: RealArray
    pull: RealArray


def own_springs(path: RealArray, stiffness: RealArray, pulls: Iterable[Pulled]) -> OwnSprings:
    """Return the springs whose pulls are nearest to a contact's, at one friction or at several.

    They are the closed form's where the contact is of closed forms, and where it hardly pulls.

    Parameters
    ----------
    path : (n, 3), m
        Positions of the indenter: x, y and depth.
    stiffness : (n,), N/m
        The closed form's stiffness along the gel.
    pulls : iterable of Pulled
        What the contact pulls along the path; all but the first are asked for only where springs are fitted.
    """
    usual, pulls = OwnSprings(), iter(pulls)
    friction, normal, pull = first = next(pulls)
    if np.abs(usual.pull(path[:, :2], Loaded(normal, stiffness), friction) - pull).max() <= SAME * np.abs(pull).max():
        return usual
    # compare at moments evenly spaced along the path
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    rows = np.unique(np.searchsorted(travelled, np.arange(0.0, travelled[-1], COMPARED_EVERY)))
    limit = friction * normal[rows]
    if np.linalg.norm(pull[rows], axis=1).max(initial=0.0) < 0.1 * limit.max(initial=0.0):
        return usual
    compared = [first, *pulls]
    reached = [one.normal[rows] * beyond_coulomb(one.pull[rows], one.friction * one.normal[rows]) for one in compared]

    def missing(values: RealArray) -> RealArray:
        springs = OwnSprings(float(np.exp(values[0])), float(values[1]))
        slid = [
            springs.pull(path[rows, :2], Loaded(normal, stiffness[rows]), one.friction) - one.pull[rows]
            for normal, one in zip(reached, compared, strict=True)
        ]
        return np.concatenate(slid).ravel()

    # fit the logarithm of the factor and the spread
    most = float(np.log(LARGEST_FACTOR))
    start = min(([0.0, spread] for spread in STARTS), key=lambda pair: float(np.sum(missing(np.array(pair)) ** 2)))
    fit = least_squares(missing, start, bounds=([-most, -1e-9], [most, 1.0]), diff_step=1e-2, max_nfev=8)
    return OwnSprings(float(np.exp(fit.x[0])), float(max(fit.x[1], 0.0)))
