"""Strengths, places, times and directions of hidden effects, drawn anew for each world.

Strengths lie between the rig's weak and strong ones, evenly in their logarithm and each by itself; where both signs
mean something, the sign is drawn. What no strength states (a frequency, an onset, the size of a loose region) lies
within a factor of 1.5 of the rig's own; a place or a direction is anywhere on the gel.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields

import numpy as np

from tactiledata.rig.hidden.effects import HIDDEN_EFFECTS

DRAWS = 61
"""Number of the random streams of drawn strengths."""
FACTOR = 1.5
"""Largest factor by which what no strength states is drawn off the rig's own."""
PLACES: Mapping[str, tuple[float, float]] = {
    "x": (-3e-3, 3e-3),
    "y": (-4.5e-3, 4.5e-3),
    "angle": (-np.pi / 2, np.pi / 2),
}
"""Places on the gel, m, and directions, rad, between which they are drawn evenly."""
SIGNED = {"yaw", "tilt", "skew", "jump", "error", "lever", "gain"}
"""Numbers of which either sign is as likely as the other."""


def drawn_parameters(name: str, seed: int, beyond: float = 1.0) -> dict[str, float]:
    """Return all numbers of one of the rig's hidden effects, in SI units, drawn by a seed.

    Parameters
    ----------
    name : str
        The rig's name of the effect.
    seed : int
        Seed of the world; the same effect has the same numbers in all worlds of a seed.
    beyond : float
        Factor by which strengths may lie below the rig's weak ones and above its strong ones.
    """
    member = HIDDEN_EFFECTS[name]
    rng = np.random.default_rng([seed, DRAWS, list(HIDDEN_EFFECTS).index(name)])
    weak, strong = member.STRENGTHS["weak"], member.STRENGTHS["strong"]
    found: dict[str, float] = {}
    for field in fields(member):
        low, high = member.RANGES[field.name]
        if field.name in PLACES:
            value = rng.uniform(*PLACES[field.name])
        elif field.name in weak:
            share, sign = rng.uniform(), rng.choice([-1.0, 1.0])
            share = share if beyond == 1.0 else _widened(share, strong[field.name] / weak[field.name], beyond)
            value = weak[field.name] * (strong[field.name] / weak[field.name]) ** share
            value *= sign if field.name in SIGNED else 1.0
        else:
            value = float(str(field.default)) * FACTOR ** rng.uniform(-1.0, 1.0)
        found[field.name] = float(np.clip(value, low, high))
    return found


def weakened(effect: str, parameters: Mapping[str, float], factor: float) -> dict[str, float]:
    """Return the numbers of one of the rig's hidden effects with all strengths times a factor, within their ranges.

    Parameters
    ----------
    effect : str
        The rig's name of the effect.
    parameters : dict, name -> float
        All its numbers, in SI units.
    factor : float
        Factor on what the rig's weak and strong ones state; the others stay.
    """
    member = HIDDEN_EFFECTS[effect]
    return {
        key: float(np.clip(value * factor, *member.RANGES[key])) if key in member.STRENGTHS["weak"] else value
        for key, value in parameters.items()
    }


def _widened(share: float, ratio: float, beyond: float) -> float:
    """Return the exponent of a ratio, 0 to 1, stretched to both sides by a factor on the value."""
    if ratio == 1.0:
        return share
    more = float(np.log(beyond) / np.log(ratio))
    return -more + share * (1.0 + 2.0 * more)
