"""The pull of a contact along the gel: as its solver finds it, and as hidden effects change it.

A solver knows one gel, and one friction all along a path. Hidden effects make friction depend on speed, age or
pressure, and the gel softer at some places. Springs and sliders tell what that changes. But a contact slips at its rim
before all of it slides, and is pushed at its flanks: no slider pulls as a solver does. So the solver is asked once
more, at another friction. What the effects change in the mean is then the solver's: a gel that is softer by one factor,
or a friction that is less by one factor, pulls as if the solver had been given it. Sliders tell only what differs from
that.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.rig.contact.contact import CONTACT_RATE
from tactiledata.rig.hidden.coulomb_limit import beyond_coulomb, within
from tactiledata.rig.hidden.own_springs import OwnSprings, Pulled, own_springs
from tactiledata.rig.hidden.slider import Loaded, SlidingLaws, slide

LESS, MORE = 0.6, 1.6
"""Frictions, relative to the contact's own, at which a solver is asked once more."""
FARTHEST = 1.5
"""How far beyond them their change is extrapolated, on a logarithmic scale."""


class SolvedPull:
    """The pull along the gel that a solver finds on one path, at several frictions, without hidden effects.

    Parameters
    ----------
    positions : (n, 3), m
        The path: x, y and depth.
    stiffness : (n,), N/m
        The closed form's tangential stiffness along it.
    friction : float
        Coulomb's coefficient.
    solve : callable
        Takes a friction coefficient and returns the wrench (n, 6), N and N m, on the indenter along the path.
    """

    def __init__(
        self, positions: RealArray, stiffness: RealArray, friction: float, solve: Callable[[float], RealArray]
    ) -> None:
        self._positions, self._stiffness, self._friction, self._solve = positions, stiffness, friction, solve
        self._known: dict[float, Pulled] = {}

    def changed(
        self, path: RealArray, areas: RealArray, pull: RealArray, before: Loaded, after: Loaded, laws: SlidingLaws
    ) -> tuple[RealArray, NDArray[np.bool_]]:
        """Return the pull on the gel (n, 2), N, with hidden effects, and whether all that touches slides (n,).

        Parameters
        ----------
        path : (n, 2), m
            Places of the indenter along the gel, near the path on which the solver is asked.
        areas : (n,), m²
            Area of the contact.
        pull : (n, 2), N
            The contact's own pull on the gel, without effects.
        before, after : Loaded
            The contact without and with the effects.
        laws : SlidingLaws
            What the effects make of friction.
        """
        friction, springs = self._friction, self.springs
        sprung = after._replace(stiffness=springs.factor * after.stiffness)
        spread = laws._replace(spreads=[springs.spread, *laws.spreads])
        slid, limit, slipping = slide(path, sprung, areas, friction, CONTACT_RATE, spread)
        # the mean factors on stiffness and limit, where it pulls
        share = _mean_ratio(after.stiffness, before.stiffness, slid)
        room = _mean_ratio(limit, friction * before.normal, slid)
        relative = room / share
        own, sliders = pull, springs.pull(path, before, friction)
        if springs != OwnSprings():
            more, slid_more = self._gained(relative)
            own, sliders = own + more, sliders + slid_more
        changed = share * own + slid - share * sliders
        return within(changed, limit * beyond_coulomb(own, relative * friction * before.normal)), slipping

    @cached_property
    def springs(self) -> OwnSprings:
        """The springs that pull along the gel as the solver does, at its friction and at less."""
        return own_springs(self._positions, self._stiffness, (self._at(factor) for factor in (1.0, LESS)))

    def _at(self, factor: float) -> Pulled:
        """Return what the solver finds at a friction, relative to the contact's own; it is asked once for each."""
        if factor not in self._known:
            friction = factor * self._friction
            wrench = self._solve(friction)
            self._known[factor] = Pulled(friction, wrench[:, 2], -wrench[:, :2])
        return self._known[factor]

    def _gained(self, factor: float) -> tuple[RealArray, RealArray]:
        """Return what solver and sliders pull more (n, 2), N, at a friction relative to the contact's own."""
        side = LESS if factor < 1.0 else MORE
        share = float(np.clip(np.log(factor) / np.log(side), 0.0, FARTHEST))
        if share == 0.0:
            return np.zeros((len(self._positions), 2)), np.zeros((len(self._positions), 2))
        there, here = self._at(side), self._at(1.0)
        slid = [
            self.springs.pull(self._positions[:, :2], Loaded(one.normal, self._stiffness), one.friction)
            for one in (there, here)
        ]
        return share * (there.pull - here.pull), share * (slid[0] - slid[1])


def _mean_ratio(changed: RealArray, plain: RealArray, pull: RealArray) -> float:
    """Return the ratio of the means of two values (n,), weighted by the size of a pull (n, 2); 1 without pull."""
    weight = np.linalg.norm(pull, axis=1)
    mean = float(weight @ plain)
    return float(weight @ changed) / mean if mean > 0 else 1.0
