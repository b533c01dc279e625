"""How certain fitted numbers are: 95 % intervals by profile or curvature, numbers at a bound, implausible strengths."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.calibrate.intervals import RISE
from tactiledata.diagnose.naming.joint_fit import JointFit, least_cost
from tactiledata.diagnose.naming.signatures import MATERIAL
from tactiledata.diagnose.residuals.wording import quantity
from tactiledata.diagnose.touches.whitened import WhitenedTouches

TURNS = 3
"""Largest number of refits in which the end of an interval is searched."""
ROUNDS = 3
"""Largest number of rounds of each of these refits, which start near their optimum."""
AT_BOUND = 0.01
"""Share of the width of its bounds within which a fitted number counts as standing at a bound."""
IMPLAUSIBLE_SIGMAS = 2.0
"""Standard errors by which a strength must exceed its plausible range to count against an effect."""


@dataclass(frozen=True)
class ProfiledInterval:
    """A fitted number with its 95 % interval.

    Parameters
    ----------
    name, unit : str
        As in tables.
    value, low, high : float
        Best value and ends of the interval, in the unit.
    low_is_bound, high_is_bound : bool
        Whether an end is a bound of the fit: the data alone would let the number go farther.
    """

    name: str
    unit: str
    value: float
    low: float
    high: float
    low_is_bound: bool = False
    high_is_bound: bool = False


def intervals(
    whitened: WhitenedTouches, fit: JointFit, dispersion: float, profiled: bool = True
) -> tuple[ProfiledInterval, ...]:
    """Return the intervals of E, nu, mu and of each number of the effects.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories of the fit.
    fit : JointFit
        Fit whose numbers are asked for; the plain fit has only the first three.
    dispersion : float
        Factor, at least 1, on the rise of the cost at which an interval ends; above 1 where more than noise is left.
    profiled : bool
        Whether the ends are searched by refits; otherwise they follow from the curvature, without further plays.
    """
    vector, (low, high) = fit.model.vector, fit.model.bounds
    deviations = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0) * dispersion)
    results = []
    for entry in range(3 + len(fit.model.coordinates)):
        ends = []
        for side in (-1.0, 1.0):
            limit = low[entry] if side < 0 else high[entry]
            reach = float(np.sqrt(RISE) * deviations[entry])
            if profiled:
                reach = _profiled(whitened, fit, entry, side, reach, abs(limit - vector[entry]), dispersion)
            ends.append(float(np.clip(vector[entry] + side * reach, low[entry], high[entry])))
        name, unit = _name(fit, entry)
        value, first, last = (_value(fit, entry, number) for number in (vector[entry], *ends))
        at_bound = bool(ends[0] <= low[entry]), bool(ends[1] >= high[entry])
        results.append(ProfiledInterval(name, unit, value, first, last, *at_bound))
    return tuple(results)


def _profiled(
    whitened: WhitenedTouches, fit: JointFit, entry: int, side: float, reach: float, room: float, dispersion: float
) -> float:
    """How far an entry of the vector can move before the cost has risen by ``RISE``, all other numbers fitted anew.

    Each round scales the reach as if the cost were a parabola with its minimum at the fit.

    Parameters
    ----------
    whitened, fit, dispersion
        As in `intervals`.
    entry : int
        Index into the model's vector.
    side : float
        -1 downwards, 1 upwards.
    reach : float
        First guess, in the unit of the vector.
    room : float
        Distance to the bound of the fit on this side.
    """
    covariance = fit.covariance
    # the other entries start where they follow this one to first order
    along = covariance[:, entry] / max(float(covariance[entry, entry]), 1e-300)
    low, high = fit.model.bounds
    for _ in range(TURNS):
        reach = min(reach, room)
        if reach <= 0.0:
            return 0.0
        start = fit.model.at(np.clip(fit.model.vector + side * reach * along, low, high), fit.model.offsets)
        rise = (least_cost(whitened, start, (entry,), ROUNDS) - fit.cost) / dispersion
        if reach >= room and rise < RISE:
            return room
        # the cost is about quadratic: within 15 % of the rise, the reach is within 7 %
        if abs(rise - RISE) < 0.15 * RISE:
            break
        reach *= float(np.clip(np.sqrt(RISE / max(rise, 1e-6)), 0.4, 2.5))
    return reach


def _name(fit: JointFit, entry: int) -> tuple[str, str]:
    """Name and unit of an entry of the vector."""
    if entry < 3:
        return MATERIAL[entry], ("Pa", "1", "1")[entry]
    coordinate = fit.model.coordinates[entry - 3]
    return fit.model.name_of(coordinate), coordinate.parameter.unit


def _value(fit: JointFit, entry: int, unit_value: float) -> float:
    """Value of an entry in its unit, from its value in the vector."""
    if entry == 0:
        return float(np.exp(unit_value))
    return float(unit_value) if entry < 3 else fit.model.coordinates[entry - 3].to_value(unit_value)


def range_checks(fit: JointFit) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return implausible strengths of a fit as "name = value", and names of fitted numbers that stand at a bound.

    A strength is implausible where it exceeds `Parameter.beyond`'s limit by ``IMPLAUSIBLE_SIGMAS`` standard errors.
    """
    errors = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))[3:]
    implausible, at_bounds = [], []
    # E, nu and mu
    gel, box = fit.model.material, fit.model.box
    for symbol, value, low, high in zip(
        MATERIAL, (gel.youngs_modulus, gel.poisson_ratio, gel.friction), box.low, box.high, strict=True
    ):
        if min(value - low, high - value) < AT_BOUND * (high - low):
            at_bounds.append(symbol)
    # numbers of the effects
    for coordinate, error in zip(fit.model.coordinates, errors, strict=False):
        setting = fit.model.settings[coordinate.setting_index]
        value, name = setting.values[coordinate.parameter.name], fit.model.name_of(coordinate)
        low, high = coordinate.bounds
        unit = coordinate.to_unit(value)
        # a strength that cannot be negative has its null at a bound, which is no sign of a poor fit
        is_null = coordinate.is_strength and value == coordinate.parameter.null
        if not is_null and min(unit - low, high - unit) < AT_BOUND * (high - low):
            at_bounds.append(name)
        if not coordinate.is_strength:
            continue
        if coordinate.parameter.beyond(value) > IMPLAUSIBLE_SIGMAS * error * coordinate.scale:
            implausible.append(f"{name} = {quantity(value, coordinate.parameter.unit)}")
    return tuple(implausible), tuple(at_bounds)
