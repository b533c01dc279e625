"""Dimensionless numbers made of covariates: the only things that open forms are built of."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.dimensions import NONE, Unit, find_unit
from tactiledata.diagnose.residuals.history import fading_memory, largest_so_far
from tactiledata.diagnose.residuals.instruments import is_logarithmic
from tactiledata.diagnose.residuals.residuals import Covariate, Residuals
from tactiledata.diagnose.residuals.wording import quantity, rounded

FADINGS = (0.1, 1.0, 10.0, 100.0)
"""s: a decade apart, as relaxation spectra are wide."""
RELAXATIONS = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
"""s: a fitted rate of a relaxation lies within a factor of 1.8 of one of them."""
LONGEST_RELAXATION = 0.6
"""Longest relaxation times that are offered, over the longest hold: a longer one looks like a creep there."""
MOST_ATOMS = 28
MOST_HISTORIES = 3
MOST_LEVELS = 6
EXPONENTS = (-2, -1, 1, 2)


@dataclass(frozen=True)
class Since:
    """Return the covariate from whose last step a time is counted, and the unit of that time.

    Parameters
    ----------
    covariate, unit : str
    """

    covariate: str
    unit: str


@dataclass(frozen=True)
class Atom:
    """A number without dimension in each frame.

    Parameters
    ----------
    name : str
        As it stands in a formula.
    values : (n,)
    complexity : int
        What it costs to say it: 1 for a covariate over its scale.
    definition : str
        From which a reader can compute it.
    since : Since, optional
        Of the time since the last step of a covariate.
    """

    name: str
    values: Array
    complexity: int
    definition: str
    since: Since | None = None


def atoms(residuals: Residuals, scales: Mapping[str, float] | None = None, time: str | None = None) -> list[Atom]:
    """Atoms, the simple ones first.

    Parameters
    ----------
    scales : dict, covariate -> float
        What it is measured by, in its own unit; by default its 95 % quantile, to one digit.
    time : str, optional
        The covariate that is the time inside a trajectory; without it nothing fades.
    """
    listed: list[Atom] = []
    for atom in itertools.chain(
        _scaled(residuals, scales or {}),
        _since_steps(residuals),
        _levels(residuals),
        _histories(residuals, scales or {}, time),
        _relaxations(residuals),
        _ratios(residuals),
        _groups(residuals),
    ):
        if len(listed) == MOST_ATOMS:
            break
        if np.ptp(atom.values) > 0 and not any(_is_same(atom.values, other.values) for other in listed):
            listed.append(atom)
    return listed


def scale_of(name: str, values: Array, scales: Mapping[str, float]) -> float:
    """What a covariate is measured by."""
    if name in scales:
        return scales[name]
    usual = float(np.quantile(np.abs(values), 0.95)) or float(np.abs(values).max())
    return float(f"{usual:.0e}") if usual > 0 else 1.0


def _scaled(residuals: Residuals, scales: Mapping[str, float]) -> Iterator[Atom]:
    for name, covariate in _given(residuals).items():
        scale = scale_of(name, covariate.values, scales)
        said = f"{name}/({quantity(scale, covariate.unit)})"
        if is_logarithmic(covariate.values):
            # a logarithm is counted from 1 where that is among the values: people know it by heart
            one = 1.0 if covariate.values.min() <= 1.0 <= covariate.values.max() and name not in scales else scale
            called = f"log10({name}/({quantity(one, covariate.unit)}))"
            meant = f"{called} is the logarithm to base 10 of {_in(name, covariate.unit)} over {one:g}"
            yield Atom(called, np.log10(covariate.values / one), 1, meant)
        yield Atom(said, covariate.values / scale, 1, f"{said} is {_in(name, covariate.unit)} over {scale:g}")


def _since_steps(residuals: Residuals) -> Iterator[Atom]:
    """Times since the last step of a covariate, over one unit of time, so that a coefficient is a rate of creep."""
    for name, covariate in residuals.covariates.items():
        if covariate.steps_of:
            called = f"{name}/(1 {covariate.unit})"
            meant = f"{called} is the time in {covariate.unit} {covariate.definition}"
            yield Atom(called, covariate.values, 2, meant, Since(covariate.steps_of, covariate.unit))


def _relaxations(residuals: Residuals) -> Iterator[Atom]:
    """Exponentials of the times since the last step of a covariate: what comes to an end rather than creep on."""
    for name, covariate in residuals.covariates.items():
        if not covariate.steps_of:
            continue
        seconds = _seconds(covariate)
        ahead = np.diff(seconds)
        shortest = float(np.median(ahead[ahead > 0]))
        for fading in RELAXATIONS:
            if shortest <= fading <= LONGEST_RELAXATION * float(seconds.max()):
                called = f"exp(-{name}/({fading:g} s))"
                meant = f"{called} is the exponential of minus the time in s over {fading:g}, {covariate.definition}"
                yield Atom(called, np.exp(-seconds / fading), 3, meant)


def _given(residuals: Residuals) -> dict[str, Covariate]:
    """Covariates that are no time since the last step of another."""
    return {name: covariate for name, covariate in residuals.covariates.items() if not covariate.steps_of}


def _levels(residuals: Residuals) -> Iterator[Atom]:
    for label, texts in residuals.labels.items():
        levels = np.unique(texts)
        if 2 <= len(levels) <= MOST_LEVELS:
            for level in levels:
                said = f"[{label} is {level}]"
                meant = f"{said} is 1 in rows where it holds, and 0 in others"
                yield Atom(said, (texts == level).astype(np.float64), 1, meant)


def _histories(residuals: Residuals, scales: Mapping[str, float], time: str | None) -> Iterator[Atom]:
    inside = [
        (name, covariate)
        for name, covariate in _given(residuals).items()
        if name != time and _varies_inside(residuals, covariate.values)
    ]
    for name, covariate in inside[:MOST_HISTORIES]:
        scale = scale_of(name, covariate.values, scales)
        said = f"({quantity(scale, covariate.unit)})"
        over = f"{_in(name, covariate.unit)} in rows of its group up to this one, in order of time, over {scale:g}"
        called = f"largest {name} so far/{said}"
        largest = largest_so_far(covariate.values, residuals.starts) / scale
        yield Atom(called, largest, 2, f"{called} is the largest {over}")
        if time is None:
            continue
        seconds = _seconds(residuals.covariates[time])
        span = float(np.median(np.maximum.reduceat(seconds, residuals.starts)
                               - np.minimum.reduceat(seconds, residuals.starts)))  # fmt: skip
        shortest = span / max(float(np.median(residuals.counts)), 1.0)
        for fading in FADINGS:
            if 0.3 * shortest <= fading <= 3.0 * span:
                memory = fading_memory(covariate.values, seconds, residuals.starts, fading)
                called = f"{name} remembered for {rounded(fading, 1)} s/{said}"
                yield Atom(
                    called, memory / scale, 2, f"{called} is m/{scale:g}: {_remembered(name, covariate, fading)}"
                )


def _in(name: str, unit: str) -> str:
    return name if unit in ("", "1", "?") else f"{name} in {unit}"


def _remembered(name: str, covariate: Covariate, fading: float) -> str:
    """How a fading memory m is computed, row by row."""
    return (
        f"in the first row of a group m is {_in(name, covariate.unit)}; in each later row, in order of time, m is its "
        f"value of the row before times exp(-(seconds since that row)/{fading:g}), plus the change of {name} since it"
    )


def _ratios(residuals: Residuals) -> Iterator[Atom]:
    """Two covariates of the same dimension, one over the other."""
    known = _known(residuals)
    for (name, values, unit), (other, below, unit_below) in itertools.permutations(known, 2):
        if unit.exponents == unit_below.exponents != NONE and (below > 0).all():
            meant = f"{name}/{other} is their ratio, both in the same unit"
            yield Atom(f"{name}/{other}", values * unit.factor / (below * unit_below.factor), 2, meant)


def _groups(residuals: Residuals) -> Iterator[Atom]:
    """Three covariates whose powers have no dimension together, as ``force/(modulus radius^2)``."""
    positive = [one for one in _known(residuals) if (one[1] > 0).all() and not one[2].is_pure]
    for three in itertools.combinations(positive, 3):
        if len({unit.exponents for _, _, unit in three}) < 3:
            continue
        for powers in itertools.product(EXPONENTS, repeat=3):
            if powers[0] < 0 or any(_total(three, powers)):
                continue
            values = np.prod([(v * u.factor) ** p for (_, v, u), p in zip(three, powers, strict=True)], axis=0)
            name = " ".join(n if p == 1 else f"{n}^{p}" for (n, _, _), p in zip(three, powers, strict=True))
            yield Atom(f"({name})", values, 3, f"({name}) is that product with every factor in SI units")


def _total(three: tuple[tuple[str, Array, Unit], ...], powers: tuple[int, ...]) -> tuple[float, ...]:
    together = [unit.power(power).exponents for (_, _, unit), power in zip(three, powers, strict=True)]
    return tuple(sum(column) for column in zip(*together, strict=True))


def _known(residuals: Residuals) -> list[tuple[str, Array, Unit]]:
    """Covariates whose unit is known; positions, which go below 0, have an origin by choice and make no ratio."""
    listed = []
    for name, covariate in _given(residuals).items():
        unit = find_unit(covariate.unit)
        if unit is not None and covariate.values.min() >= 0:
            listed.append((name, covariate.values, unit))
    return listed


def _varies_inside(residuals: Residuals, values: Array) -> bool:
    spread = np.maximum.reduceat(values, residuals.starts) - np.minimum.reduceat(values, residuals.starts)
    return bool((spread > 0).mean() > 0.5)


def _seconds(time: Covariate) -> Array:
    unit = find_unit(time.unit)
    return time.values * (unit.factor if unit is not None and not unit.is_pure else 1.0)


def _is_same(values: Array, other: Array) -> bool:
    """Whether two atoms differ by a factor only."""
    size = float(np.linalg.norm(values)) * float(np.linalg.norm(other))
    return bool(abs(float(values @ other)) > 0.9999 * size)
