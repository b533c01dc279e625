"""The pull of sliders on springs, whose limit of friction depends on speed, age, pressure and direction."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from tactiledata.arrays import RealArray
from tactiledata.rig.hidden.base import FrictionFactor, Slide

SLIDERS = 12
"""Number of parts of a contact whose limits are spread."""
CRITICAL_SLIP = 3e-5
"""Length of sliding, m, in which a contact loses its age."""
SLOWEST = 1e-9
"""Speed, m/s, below which a contact is at rest."""
SAME_SPEED = 1e-9
"""Share of a speed within which it is found."""
CREEP = 1e-5
"""Speed, m/s, below which a contact creeps under any pull: the limit returned is that of this speed at least."""


class Loaded(NamedTuple):
    """Normal force and tangential stiffness of a contact.

    Parameters
    ----------
    normal : (n,), N
        Normal force.
    stiffness : (n,), N/m
        Tangential stiffness.
    """

    normal: RealArray
    stiffness: RealArray


class SlidingLaws(NamedTuple):
    """Laws of the parts of a contact, beside Coulomb's.

    Parameters
    ----------
    factors : sequence of callables
        Each takes a `Slide` and gives a factor on the limit; none may fall with the speed at constant age.
    spreads : sequence of float
        Reasons why the limits of the parts differ, see `relative_limits`; without any it is one slider.
    memory : (n,), optional
        Share of a pull that a spring still holds k samples later, 1 at k = 0 (Boltzmann's superposition): parts that
        slide are at their limit at each moment, parts that stick relax. ``None``: the springs do not relax.
    """

    factors: Sequence[FrictionFactor] = ()
    spreads: Sequence[float] = ()
    memory: RealArray | None = None


COULOMB = SlidingLaws()
"""Coulomb's law alone, with one slider and springs that do not relax."""


def slide(
    path: RealArray, loaded: Loaded, areas: RealArray, friction: float, rate: float, laws: SlidingLaws = COULOMB
) -> tuple[RealArray, RealArray, NDArray[np.bool_]]:
    """Return the pull on the gel (n, 2), N, its limit (n,), N, and whether all of the contact slides (n,).

    The speed of sliding is sought at which springs, path and limit agree in each step. The limit that is returned is
    that of sliding at ``CREEP`` at least: a law that falls with the logarithm of speed has none at rest.

    Parameters
    ----------
    path : (n, 2), m
        Places of the indenter along the gel.
    loaded : Loaded
        The contact's normal force and stiffness.
    areas : (n,), m²
        Area of the contact.
    friction : float
        Coulomb's coefficient.
    rate : Hz
        Rate of the samples.
    laws : SlidingLaws
        Laws beside Coulomb's.
    """
    count, parts = len(path), relative_limits(*laws.spreads).tolist()
    each = len(parts)
    pulls, limits, slips = np.zeros((count, 2)), np.zeros(count), np.zeros(count, dtype=bool)
    mean_stiffness = (loaded.stiffness + np.roll(loaded.stiffness, 1)) / 2
    steps = np.diff(path, axis=0, prepend=path[:1]) * mean_stiffness[:, None] / each
    age, dt = 0.0, 1 / rate
    xs, ys = [0.0] * each, [0.0] * each
    given, began = np.zeros((count if laws.memory is not None else 0, 2, each)), 0
    # plain numbers: few parts and many moments
    for moment, (force, stiffness, area, (step_x, step_y)) in enumerate(
        zip(loaded.normal.tolist(), loaded.stiffness.tolist(), areas.tolist(), steps.tolist(), strict=True)
    ):
        if force <= 0:
            xs, ys, age, began = [0.0] * each, [0.0] * each, 0.0, moment + 1
            continue
        # the springs before they slide
        if laws.memory is None:
            xs, ys = [x + step_x for x in xs], [y + step_y for y in ys]
        else:
            given[moment] = [[step_x], [step_y]]
            xs, ys = np.tensordot(laws.memory[moment - began :: -1], given[began : moment + 1], axes=1).tolist()
        # the limit at the speed of sliding
        x, y = sum(xs), sum(ys)
        state = Slide(0.0, force / max(area, 1e-9), age, float(np.arctan2(y, x)))
        limit, speed, limits[moment] = _limit(hypot(x, y), stiffness * dt, friction * force, state, laws.factors)
        # parts beyond their share of the limit slide back to it
        slid, before = 0, (xs, ys)
        kept_x, kept_y = [], []
        for part, x, y in zip(parts, xs, ys, strict=True):
            size, share = hypot(x, y), limit * part / each
            if size > share:
                slid += 1
                x, y = x * share / size, y * share / size
            kept_x.append(x)
            kept_y.append(y)
        xs, ys = kept_x, kept_y
        if laws.memory is not None:
            given[moment] += np.array((xs, ys)) - before
        age = (age + dt) / (1 + dt * speed / CRITICAL_SLIP)
        pulls[moment], slips[moment] = (sum(xs), sum(ys)), slid == each
    return pulls, limits, slips


def relative_limits(*spreads: float) -> RealArray:
    """Return the limits (k,) of the parts of a contact, relative to their mean.

    Parameters
    ----------
    *spreads : float
        Relative half-widths, one for each reason why limits differ: for each by itself they lie evenly within
        1 - spread and 1 + spread of the mean, and reasons multiply. Each part stands for as many of the products as
        every other.
    """
    limits = np.ones(1)
    for spread in spreads:
        if spread > 0:
            evenly = 1 + spread * (2 * (np.arange(SLIDERS) + 0.5) / SLIDERS - 1)
            products = np.sort(np.outer(limits, evenly).ravel())
            limits = products.reshape(SLIDERS, -1).mean(axis=1)
    return limits


def _limit(
    trial: float, give: float, coulomb: float, state: Slide, factors: Sequence[FrictionFactor]
) -> tuple[float, float, float]:
    """Return the limit, N, the speed of sliding, m/s, at which a pull falls to it, and the limit at ``CREEP`` at least.

    Parameters
    ----------
    trial : N
        Pull before sliding.
    give : N s/m
        Loss of pull per speed of sliding in one step.
    coulomb : N
        Coulomb's limit.
    state : Slide
        State of sliding at speed 0.
    factors : sequence of callables
        Factors on the limit.
    """

    def limit_at(speed: float) -> float:
        """Return the limit, N, at a speed of sliding, m/s."""
        slid = Slide(speed, *state[1:])
        limit = coulomb
        for factor in factors:
            limit *= factor(slid)
        return limit

    def excess(speed: float) -> float:
        """Return by how much the pull exceeds the limit, N, where it slides at a speed, m/s."""
        return trial - give * speed - limit_at(speed)

    still = limit_at(SLOWEST)
    if trial <= still or give <= 0:
        return still, 0.0, max(still, limit_at(CREEP))
    # limits rise with the speed: at most that which the limit at rest leaves, at least that which its own limit leaves
    speed = (trial - still) / give
    slowest = max((trial - limit_at(speed)) / give, SLOWEST)
    if slowest < (1 - SAME_SPEED) * speed:
        tolerance = SAME_SPEED * SLOWEST
        bracket = slowest, speed
        speed = slowest if excess(slowest) <= 0 else float(brentq(excess, *bracket, xtol=tolerance, rtol=SAME_SPEED))
    return limit_at(speed), speed, limit_at(max(speed, CREEP))


def areas_of(radius: Any) -> RealArray:
    """Return the areas (n,), m², of round contacts of given radii (n,), m."""
    areas: RealArray = np.pi * np.asarray(radius) ** 2
    return areas
