"""Intervals by the profile of the likelihood: how far a number can go while all others follow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.calibrate.intervals import RISE
from tactiledata.diagnose.naming.joint_fit import JointFit, joint_fit
from tactiledata.diagnose.naming.signatures import MATERIAL
from tactiledata.diagnose.touches.whitened import WhitenedTouches

TURNS = 3
ROUNDS = 3


@dataclass(frozen=True)
class ProfiledInterval:
    """A number and what is known of it, 95 %.

    Parameters
    ----------
    name, unit : str
    value, low, high : float
    low_is_bound, high_is_bound : bool
        Whether an end is that of what was tried: the data alone would let the number go further.
    """

    name: str
    unit: str
    value: float
    low: float
    high: float
    low_is_bound: bool = False
    high_is_bound: bool = False


def intervals(
    cases: WhitenedTouches, fit: JointFit, numerical: Array, dispersion: float, profiled: bool = True
) -> tuple[ProfiledInterval, ...]:
    """Of E, nu, mu and each number of the effects; the plain fit has only the first three.

    Parameters
    ----------
    numerical : (N, 6, e)
        As in the fit.
    dispersion : float
        By which the cost must rise more, where more than noise is left.
    profiled : bool
        Otherwise from the curvature at the optimum: no further plays.
    """
    vector, (low, high) = fit.model.vector, fit.model.bounds
    deviations = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0) * dispersion)
    found = []
    for place in range(3 + len(fit.model.coordinates)):
        ends = []
        for side in (-1.0, 1.0):
            limit = low[place] if side < 0 else high[place]
            reach = float(np.sqrt(RISE) * deviations[place])
            if profiled:
                reach = _profiled(cases, fit, numerical, place, side, reach, abs(limit - vector[place]), dispersion)
            ends.append(float(np.clip(vector[place] + side * reach, low[place], high[place])))
        name, unit = _name(fit, place)
        value, first, last = (_value(fit, place, each) for each in (vector[place], *ends))
        at_bound = bool(ends[0] <= low[place]), bool(ends[1] >= high[place])
        found.append(ProfiledInterval(name, unit, value, first, last, *at_bound))
    return tuple(found)


def _profiled(
    cases: WhitenedTouches, fit: JointFit, numerical: Array, place: int, side: float, reach: float, room: float,
    dispersion: float,
) -> float:  # fmt: skip
    """How far the number goes until the cost has risen enough, all else fitted anew; by parabolas through the best."""
    covariance = fit.covariance
    along = covariance[:, place] / max(float(covariance[place, place]), 1e-300)
    low, high = fit.model.bounds
    for _ in range(TURNS):
        reach = min(reach, room)
        if reach <= 0.0:
            return 0.0
        start = fit.model.at(np.clip(fit.model.vector + side * reach * along, low, high), fit.model.offsets)
        rise = (joint_fit(cases, numerical, start, held=(place,), rounds=ROUNDS).cost - fit.cost) / dispersion
        if reach >= room and rise < RISE:
            return room
        if abs(rise - RISE) < 0.15 * RISE:
            break
        reach *= float(np.clip(np.sqrt(RISE / max(rise, 1e-6)), 0.4, 2.5))
    return reach


def _name(fit: JointFit, place: int) -> tuple[str, str]:
    if place < 3:
        return MATERIAL[place], ("Pa", "1", "1")[place]
    one = fit.model.coordinates[place - 3]
    return fit.model.name_of(one), one.parameter.unit


def _value(fit: JointFit, place: int, unit_value: float) -> float:
    if place == 0:
        return float(np.exp(unit_value))
    return float(unit_value) if place < 3 else fit.model.coordinates[place - 3].to_value(unit_value)
