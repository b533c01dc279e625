"""Atoms: dimensionless numbers made of covariates, from which the terms of an open form are built."""

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
"""Time constants of fading memories, s; a decade apart, as relaxation spectra are wide."""
RELAXATIONS = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
"""Time constants of relaxations, s; every rate in between lies within a factor of 1.8 of one of them."""
LONGEST_RELAXATION = 0.6
"""Longest relaxation time that is tried, over the longest hold; a longer one looks like a creep."""
MOST_ATOMS = 28
"""Most atoms in all: candidates grow with their square."""
MOST_HISTORIES = 3
"""Most covariates whose history is followed inside a trajectory."""
MOST_LEVELS = 6
"""Most levels of a label for which each level becomes an atom."""
EXPONENTS = (-2, -1, 1, 2)
"""Powers of a covariate in a dimensionless group."""


@dataclass(frozen=True)
class Since:
    """The origin of a time that is counted from the last step of a covariate.

    Parameters
    ----------
    covariate : str
        Name of the covariate that steps.
    unit : str
        Unit of the time.
    """

    covariate: str
    unit: str


@dataclass(frozen=True)
class Atom:
    """A dimensionless number in each frame.

    Parameters
    ----------
    name : str
        Name of the atom in a formula.
    values : (n,)
        Value in each frame.
    complexity : int
        Cost of the atom in a formula: 1 for a covariate over its scale.
    definition : str
        How a reader can compute the atom.
    since : Since, optional
        Given where the atom is the time since the last step of a covariate.
    """

    name: str
    values: Array
    complexity: int
    definition: str
    since: Since | None = None


def atoms(residuals: Residuals, scales: Mapping[str, float] | None = None, time: str | None = None) -> list[Atom]:
    """Return at most `MOST_ATOMS` atoms of covariates and labels, the simple ones first, without duplicates.

    Parameters
    ----------
    residuals : Residuals
        Gives covariates, labels and trajectories.
    scales : dict, covariate -> float
        What a covariate is divided by, in its own unit; by default its 95 % quantile, to one digit.
    time : str, optional
        Covariate that is the time inside a trajectory; without it no memory fades.
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
    """Return what a covariate is divided by, in its own unit.

    Parameters
    ----------
    name : str
        Name of the covariate.
    values : (n,)
        Its values; without a given scale their 95 % quantile, to one digit, is used.
    scales : dict, covariate -> float
        Given scales.
    """
    if name in scales:
        return scales[name]
    usual = float(np.quantile(np.abs(values), 0.95)) or float(np.abs(values).max())
    return float(f"{usual:.0e}") if usual > 0 else 1.0


def _scaled(residuals: Residuals, scales: Mapping[str, float]) -> Iterator[Atom]:
    """Yield each covariate over its scale, after its logarithm where it varies over decades."""
    for name, covariate in _measured_covariates(residuals).items():
        scale = scale_of(name, covariate.values, scales)
        ratio = f"{name}/({quantity(scale, covariate.unit)})"
        if is_logarithmic(covariate.values):
            # a logarithm is counted from 1 where 1 is among the values: readers know such numbers by heart
            origin = 1.0 if covariate.values.min() <= 1.0 <= covariate.values.max() and name not in scales else scale
            logarithm = f"log10({name}/({quantity(origin, covariate.unit)}))"
            definition = f"{logarithm} is the logarithm to base 10 of {_in(name, covariate.unit)} over {origin:g}"
            yield Atom(logarithm, np.log10(covariate.values / origin), 1, definition)
        yield Atom(ratio, covariate.values / scale, 1, f"{ratio} is {_in(name, covariate.unit)} over {scale:g}")


def _since_steps(residuals: Residuals) -> Iterator[Atom]:
    """Yield times since the last step of a covariate over one unit of time: a coefficient is a rate of creep."""
    for name, covariate in residuals.covariates.items():
        if covariate.steps_of:
            label = f"{name}/(1 {covariate.unit})"
            definition = f"{label} is the time in {covariate.unit} {covariate.definition}"
            yield Atom(label, covariate.values, 2, definition, Since(covariate.steps_of, covariate.unit))


def _relaxations(residuals: Residuals) -> Iterator[Atom]:
    """Yield exponentials of the times since the last step of a covariate: relaxations, which come to an end."""
    for name, covariate in residuals.covariates.items():
        if not covariate.steps_of:
            continue
        seconds = _seconds(covariate)
        ahead = np.diff(seconds)
        shortest = float(np.median(ahead[ahead > 0]))
        for fading in RELAXATIONS:
            if shortest <= fading <= LONGEST_RELAXATION * float(seconds.max()):
                label = f"exp(-{name}/({fading:g} s))"
                definition = (
                    f"{label} is the exponential of minus the time in s over {fading:g}, {covariate.definition}"
                )
                yield Atom(label, np.exp(-seconds / fading), 3, definition)


def _measured_covariates(residuals: Residuals) -> dict[str, Covariate]:
    """Return the covariates other than times since the last step of a covariate."""
    return {name: covariate for name, covariate in residuals.covariates.items() if not covariate.steps_of}


def _levels(residuals: Residuals) -> Iterator[Atom]:
    """Yield an indicator of each level of every label with few levels."""
    for label, texts in residuals.labels.items():
        levels = np.unique(texts)
        if 2 <= len(levels) <= MOST_LEVELS:
            for level in levels:
                name = f"[{label} is {level}]"
                definition = f"{name} is 1 in rows where it holds, and 0 in others"
                yield Atom(name, (texts == level).astype(np.float64), 1, definition)


def _histories(residuals: Residuals, scales: Mapping[str, float], time: str | None) -> Iterator[Atom]:
    """Yield largest values so far and fading memories of covariates that vary inside trajectories."""
    inside = [
        (name, covariate)
        for name, covariate in _measured_covariates(residuals).items()
        if name != time and _varies_inside(residuals, covariate.values)
    ]
    for name, covariate in inside[:MOST_HISTORIES]:
        # the largest value so far
        scale = scale_of(name, covariate.values, scales)
        divisor = f"({quantity(scale, covariate.unit)})"
        over = f"{_in(name, covariate.unit)} in rows of its group up to this one, in order of time, over {scale:g}"
        label = f"largest {name} so far/{divisor}"
        largest = largest_so_far(covariate.values, residuals.starts) / scale
        yield Atom(label, largest, 2, f"{label} is the largest {over}")
        if time is None:
            continue
        # memories that fade within a trajectory, no faster than its frames follow one another
        seconds = _seconds(residuals.covariates[time])
        span = float(np.median(np.maximum.reduceat(seconds, residuals.starts)
                               - np.minimum.reduceat(seconds, residuals.starts)))  # fmt: skip
        shortest = span / max(float(np.median(residuals.counts)), 1.0)
        for fading in FADINGS:
            if 0.3 * shortest <= fading <= 3.0 * span:
                memory = fading_memory(covariate.values, seconds, residuals.starts, fading)
                label = f"{name} remembered for {rounded(fading, 1)} s/{divisor}"
                yield Atom(
                    label, memory / scale, 2, f"{label} is m/{scale:g}: {_memory_definition(name, covariate, fading)}"
                )


def _in(name: str, unit: str) -> str:
    """Return a name with its unit, as ``"depth in mm"``; without a unit the name alone."""
    return name if unit in ("", "1", "?") else f"{name} in {unit}"


def _memory_definition(name: str, covariate: Covariate, fading: float) -> str:
    """Return how a fading memory m is computed, row by row, in words."""
    return (
        f"in the first row of a group m is {_in(name, covariate.unit)}; in each later row, in order of time, m is its "
        f"value of the row before times exp(-(seconds since that row)/{fading:g}), plus the change of {name} since it"
    )


def _ratios(residuals: Residuals) -> Iterator[Atom]:
    """Yield ratios of two covariates of the same dimension."""
    known = _with_units(residuals)
    for (name, values, unit), (other, below, unit_below) in itertools.permutations(known, 2):
        if unit.exponents == unit_below.exponents != NONE and (below > 0).all():
            definition = f"{name}/{other} is their ratio, both in the same unit"
            yield Atom(f"{name}/{other}", values * unit.factor / (below * unit_below.factor), 2, definition)


def _groups(residuals: Residuals) -> Iterator[Atom]:
    """Yield products of powers of three covariates that have no dimension together, as force/(modulus radius^2)."""
    positive = [known for known in _with_units(residuals) if (known[1] > 0).all() and not known[2].is_pure]
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
    """Return the exponents of the base units of a product of powers; all 0 where the product has no dimension."""
    together = [unit.power(power).exponents for (_, _, unit), power in zip(three, powers, strict=True)]
    return tuple(sum(column) for column in zip(*together, strict=True))


def _with_units(residuals: Residuals) -> list[tuple[str, Array, Unit]]:
    """Return name, values and unit of the covariates with a known unit and no negative value.

    Covariates with negative values, as positions, have an arbitrary origin: their ratios mean nothing.
    """
    listed = []
    for name, covariate in _measured_covariates(residuals).items():
        unit = find_unit(covariate.unit)
        if unit is not None and covariate.values.min() >= 0:
            listed.append((name, covariate.values, unit))
    return listed


def _varies_inside(residuals: Residuals, values: Array) -> bool:
    """Return whether values (n,) vary inside more than half of the trajectories."""
    spread = np.maximum.reduceat(values, residuals.starts) - np.minimum.reduceat(values, residuals.starts)
    return bool((spread > 0).mean() > 0.5)


def _seconds(time: Covariate) -> Array:
    """Return a time in seconds (n,); a time without a known unit is taken to be in seconds."""
    unit = find_unit(time.unit)
    return time.values * (unit.factor if unit is not None and not unit.is_pure else 1.0)


def _is_same(values: Array, other: Array) -> bool:
    """Return whether two atoms differ only by a factor: their absolute cosine exceeds 0.9999."""
    size = float(np.linalg.norm(values)) * float(np.linalg.norm(other))
    return bool(abs(float(values @ other)) > 0.9999 * size)
