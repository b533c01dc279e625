"""How certain fitted numbers are: 95 % intervals by profile or curvature, numbers at a bound, implausible strengths."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain, islice

import numpy as np

from tactiledata.calibrate.intervals import RISE
from tactiledata.compute.base import Scheduler
from tactiledata.compute.local import LocalScheduler
from tactiledata.diagnose.naming.joint_fit import JointFit, least_cost
from tactiledata.diagnose.naming.signatures import MATERIAL
from tactiledata.diagnose.residuals.wording import quantity
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.errors import UsageError

TURNS = 3
"""Largest number of refits in which the end of an interval is searched."""
SHORTER = 0.7
"""Share of a reach that is tried where gel and springs find no balance at the whole one."""
ROUNDS = 3
"""Largest number of rounds of each of these refits, which start near their optimum."""
AT_BOUND = 0.01
"""Share of the width of its bounds within which a fitted number counts as standing at a bound."""
SIDES = (-1.0, 1.0)
"""Directions of the two ends of an interval."""
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


@dataclass(frozen=True)
class IntervalRequest:
    """A fit whose intervals are asked for.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories of the fit.
    fit : JointFit
        Fit whose numbers are asked for: E, nu, mu, and each number of its effects.
    dispersion : float
        Factor, at least 1, on the rise of the cost at which an interval ends; above 1 where more than noise is left.
    """

    whitened: WhitenedTouches
    fit: JointFit
    dispersion: float

    @property
    def ends(self) -> list[_End]:
        """Both ends of the interval of each number, in order."""
        return [_End(self, entry, side) for entry in range(3 + len(self.fit.model.coordinates)) for side in SIDES]

    def reached(self, reaches: Sequence[float]) -> tuple[ProfiledInterval, ...]:
        """Return the intervals from how far each of ``ends`` lies from the best value, in the unit of the vector."""
        fit = self.fit
        vector, (low, high) = fit.model.vector, fit.model.bounds
        results = []
        for entry in range(3 + len(fit.model.coordinates)):
            ends = [
                float(np.clip(vector[entry] + side * reach, low[entry], high[entry]))
                for side, reach in zip(SIDES, reaches[2 * entry : 2 * entry + 2], strict=True)
            ]
            name, unit = _name(fit, entry)
            value, first, last = (_value(fit, entry, number) for number in (vector[entry], *ends))
            at_bound = bool(ends[0] <= low[entry]), bool(ends[1] >= high[entry])
            results.append(ProfiledInterval(name, unit, value, first, last, *at_bound))
        return tuple(results)


def intervals(request: IntervalRequest) -> tuple[ProfiledInterval, ...]:
    """Return the intervals of E, nu, mu and of each number of the effects by the curvature, without further plays."""
    return request.reached([end.by_curvature for end in request.ends])


def profiled_intervals(
    requests: Sequence[IntervalRequest], runner: Scheduler | None = None
) -> list[tuple[ProfiledInterval, ...]]:
    """Return the intervals of fits, each end searched by refits.

    Parameters
    ----------
    requests : sequence of IntervalRequest
        The fits.
    runner : Scheduler, optional
        Where ends are searched; in this process where ``None``.
    """
    ends_of = [request.ends for request in requests]
    outcomes = (runner or LocalScheduler()).outcomes(_profiled, list(chain.from_iterable(ends_of)))
    reaches = (outcome.value for outcome in outcomes)
    return [request.reached(list(islice(reaches, len(ends)))) for request, ends in zip(requests, ends_of, strict=True)]


@dataclass(frozen=True)
class _End:
    """An end of the interval of one number: its entry of the model's vector, and -1 downwards or 1 upwards."""

    request: IntervalRequest
    entry: int
    side: float

    @property
    def by_curvature(self) -> float:
        """How far it lies from the best value by the curvature of the cost, in the unit of the vector."""
        variance = max(float(self.request.fit.covariance[self.entry, self.entry]), 0.0)
        return float(np.sqrt(RISE * variance * self.request.dispersion))

    @property
    def room(self) -> float:
        """Distance to the bound of the fit on this side."""
        low, high = self.request.fit.model.bounds
        limit = low[self.entry] if self.side < 0 else high[self.entry]
        return float(abs(limit - self.request.fit.model.vector[self.entry]))


def _profiled(end: _End) -> float:
    """How far an entry of the vector can move before the cost has risen by ``RISE``, all other numbers fitted anew.

    Each round scales the reach as if the cost were a parabola with its minimum at the fit. Where gel and springs find
    no balance, the next round tries ``SHORTER`` of the reach, and nothing beyond it. Where the last round finds none
    either, the shorter reach is returned.
    """
    request, entry, room, reach = end.request, end.entry, end.room, end.by_curvature
    fit = request.fit
    covariance = fit.covariance
    # the other entries start where they follow this one to first order
    along = covariance[:, entry] / max(float(covariance[entry, entry]), 1e-300)
    low, high = fit.model.bounds
    for _ in range(TURNS):
        reach = min(reach, room)
        if reach <= 0.0:
            return 0.0
        start = fit.model.at(np.clip(fit.model.vector + end.side * reach * along, low, high), fit.model.offsets)
        try:
            rise = (least_cost(request.whitened, start, (entry,), ROUNDS) - fit.cost) / request.dispersion
        except UsageError:
            reach = room = SHORTER * reach
            continue
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
