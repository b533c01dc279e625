"""A contact as sliders on springs whose limit of friction depends on speed, age, pressure and direction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.rig.hidden.base import FrictionFactor, Slide

SLIDERS = 12
"""Parts of a contact whose limits are spread."""
CRITICAL_SLIP = 3e-5
"""m of sliding in which a contact forgets its age."""
HALVINGS = 30
"""Of the logarithm of the sliding speed, from ``SLOWEST`` to ``FASTEST`` m/s."""
SLOWEST, FASTEST = 1e-9, 1.0
CREEP = 1e-5
"""m/s: slower, a contact creeps under whatever pull it is under, and no pull is beyond its limit."""


def slide(
    path: RealArray,
    normal: RealArray,
    stiffness: RealArray,
    areas: RealArray,
    friction: float,
    rate: float,
    factors: Sequence[FrictionFactor] = (),
    spread: float = 0.0,
    memory: RealArray | None = None,
) -> tuple[RealArray, RealArray, NDArray[np.bool_]]:
    """Pull (n, 2), N, on the gel; its limit (n,), N; whether all slides (n,).

    The speed of sliding is found so that springs, path and limit agree in each step. The limit that is returned is that
    of sliding at ``CREEP`` at least: a law that falls with the logarithm of speed has none at rest.

    Parameters
    ----------
    path : (n, 2), m
    normal : (n,), N
    stiffness : (n,), N/m
    areas : (n,), m², of the contact
    friction : float
        Coulomb's.
    rate : Hz, of the samples
    factors : sequence of callables
        Each takes a `Slide` and gives what the limit is multiplied by; none may fall with the speed at constant age.
    spread : float
        Limits of the parts lie evenly within 1 - spread and 1 + spread of the mean.
    memory : (n,), optional
        Share of a pull that a spring still holds after so many samples, 1 at once (Boltzmann's superposition): what
        slides is at its limit at each moment, what sticks relaxes. ``None``: springs forget nothing.
    """
    count = len(path)
    parts = np.ones(1) if spread == 0 else 1 + spread * (2 * (np.arange(SLIDERS) + 0.5) / SLIDERS - 1)
    pulls, limits, slips = np.zeros((count, 2)), np.zeros(count), np.zeros(count, dtype=bool)
    steps = np.diff(path, axis=0, prepend=path[:1]) * ((stiffness + np.roll(stiffness, 1)) / 2)[:, None]
    held, age, dt = np.zeros((len(parts), 2)), 0.0, 1 / rate
    given, began = np.zeros((count, len(parts), 2)), 0
    for moment in range(count):
        force = max(float(normal[moment]), 0.0)
        if force == 0:
            held, age, began = np.zeros_like(held), 0.0, moment + 1
            continue
        if memory is None:
            held = held + steps[moment] / len(parts)
        else:
            given[moment] = steps[moment] / len(parts)
            held = np.tensordot(memory[moment - began :: -1], given[began : moment + 1], axes=1)
        x, y = held.sum(axis=0).tolist()
        trial, direction = float(np.hypot(x, y)), float(np.arctan2(y, x))
        pressure = force / max(float(areas[moment]), 1e-9)
        limit, speed, most = _limit(
            trial, float(stiffness[moment]) * dt, friction * force, Slide(0.0, pressure, age, direction), factors
        )
        shares = limit * parts / len(parts)
        sizes = np.hypot(held[:, 0], held[:, 1])
        over = sizes > shares
        kept = held * np.where(over, shares / np.maximum(sizes, 1e-300), 1.0)[:, None]
        given[moment] += kept - held
        held = kept
        age = (age + dt) / (1 + dt * speed / CRITICAL_SLIP)
        pulls[moment], limits[moment], slips[moment] = held.sum(axis=0), most, over.all()
    return pulls, limits, slips


def _limit(
    trial: float, give: float, coulomb: float, state: Slide, factors: Sequence[FrictionFactor]
) -> tuple[float, float, float]:
    """Limit, N, the speed of sliding, m/s, at which a pull falls to it, and the limit at ``CREEP`` at least.

    ``trial``: N, before it slides; ``give``: N s/m.
    """

    def limit_at(speed: float) -> float:
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
    """Areas (n,), m², of round contacts."""
    areas: RealArray = np.pi * np.asarray(radius) ** 2
    return areas
