"""The pull of sliders on springs, whose limit of friction depends on speed, age, pressure and direction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.rig.hidden.base import FrictionFactor, Slide

SLIDERS = 12
"""Number of parts of a contact whose limits are spread."""
CRITICAL_SLIP = 3e-5
"""Length of sliding, m, in which a contact loses its age."""
HALVINGS = 30
"""Bisections of the logarithm of the sliding speed."""
SLOWEST, FASTEST = 1e-9, 1.0
"""Sliding speeds, m/s, between which the speed is sought."""
CREEP = 1e-5
"""Speed, m/s, below which a contact creeps under any pull: the limit returned is that of this speed at least."""


def slide(
    path: RealArray,
    normal: RealArray,
    stiffness: RealArray,
    areas: RealArray,
    friction: float,
    rate: float,
    factors: Sequence[FrictionFactor] = (),
    spreads: Sequence[float] = (),
    memory: RealArray | None = None,
) -> tuple[RealArray, RealArray, NDArray[np.bool_]]:
    """Return the pull on the gel (n, 2), N, its limit (n,), N, and whether all of the contact slides (n,).

    The speed of sliding is sought at which springs, path and limit agree in each step. The limit that is returned is
    that of sliding at ``CREEP`` at least: a law that falls with the logarithm of speed has none at rest.

    Parameters
    ----------
    path : (n, 2), m
        Places of the indenter along the gel.
    normal : (n,), N
        Normal force.
    stiffness : (n,), N/m
        Tangential stiffness.
    areas : (n,), m²
        Area of the contact.
    friction : float
        Coulomb's coefficient.
    rate : Hz
        Rate of the samples.
    factors : sequence of callables
        Each takes a `Slide` and gives a factor on the limit; none may fall with the speed at constant age.
    spreads : sequence of float
        Reasons why the limits of the parts differ, see `relative_limits`; without any it is one slider.
    memory : (n,), optional
        Share of a pull that a spring still holds k samples later, 1 at k = 0 (Boltzmann's superposition): parts that
        slide are at their limit at each moment, parts that stick relax. ``None``: the springs do not relax.
    """
    count = len(path)
    parts = relative_limits(*spreads)
    pulls, limits, slips = np.zeros((count, 2)), np.zeros(count), np.zeros(count, dtype=bool)
    steps = np.diff(path, axis=0, prepend=path[:1]) * ((stiffness + np.roll(stiffness, 1)) / 2)[:, None]
    held, age, dt = np.zeros((len(parts), 2)), 0.0, 1 / rate
    given, began = np.zeros((count, len(parts), 2)), 0
    for moment in range(count):
        force = max(float(normal[moment]), 0.0)
        if force == 0:
            held, age, began = np.zeros_like(held), 0.0, moment + 1
            continue
        # the springs before they slide
        if memory is None:
            held = held + steps[moment] / len(parts)
        else:
            given[moment] = steps[moment] / len(parts)
            held = np.tensordot(memory[moment - began :: -1], given[began : moment + 1], axes=1)
        # the limit at the speed of sliding
        x, y = held.sum(axis=0).tolist()
        trial, direction = float(np.hypot(x, y)), float(np.arctan2(y, x))
        pressure = force / max(float(areas[moment]), 1e-9)
        limit, speed, most = _limit(
            trial, float(stiffness[moment]) * dt, friction * force, Slide(0.0, pressure, age, direction), factors
        )
        # parts beyond their share of the limit slide back to it
        shares = limit * parts / len(parts)
        sizes = np.hypot(held[:, 0], held[:, 1])
        over = sizes > shares
        kept = held * np.where(over, shares / np.maximum(sizes, 1e-300), 1.0)[:, None]
        given[moment] += kept - held
        held = kept
        age = (age + dt) / (1 + dt * speed / CRITICAL_SLIP)
        pulls[moment], limits[moment], slips[moment] = held.sum(axis=0), most, over.all()
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
        slid = state._replace(speed=speed)
        limit = coulomb
        for factor in factors:
            limit *= factor(slid)
        return limit

    still = limit_at(SLOWEST)
    if trial <= still or give <= 0:
        return still, 0.0, max(still, limit_at(CREEP))
    low, high = np.log(SLOWEST), np.log(FASTEST)
    for _ in range(HALVINGS if factors else 0):
        middle = (low + high) / 2
        speed = float(np.exp(middle))
        if trial - give * speed > limit_at(speed):
            low = middle
        else:
            high = middle
    speed = float(np.exp(low)) if factors else (trial - still) / give
    return limit_at(speed), speed, limit_at(max(speed, CREEP))


def areas_of(radius: Any) -> RealArray:
    """Return the areas (n,), m², of round contacts of given radii (n,), m."""
    areas: RealArray = np.pi * np.asarray(radius) ** 2
    return areas
