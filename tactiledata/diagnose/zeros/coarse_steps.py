"""Whether a force sensor reads in coarse steps: the distances between the numbers that it logs.

A sensor or its driver rounds a load to a multiple of a step. Steps far below the noise do not matter. Coarse ones add
to the noise, and hide small changes. The readings are those of the log: an offset, a rotation or a weight that was
taken off would hide the step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.residuals import joined_names
from tactiledata.diagnose.residuals.wording import quantity

AXES = ("fx", "fy", "fz")
"""Components that are looked at."""
FEWEST_AXES = 2
"""Fewest components that must show a coarse step; one alone may be broken otherwise."""
FEWEST = 100
"""Fewest readings of a component."""
LEAST_ERROR = 0.01
"""Root mean square of the rounding, N, up to which a step does not matter: a drift of that size does not either."""
LEAST_SHARE = 0.05
"""Share of the variance from reading to reading that rounding must bring to matter."""
SLOWEST = 0.9
"""Share of the changes between readings that count as noise; the others, the largest, are motion."""
DIGITS = 9
"""Digits after the point to which numbers count as equal, in N or N m."""
STRAYS = 0.1
"""Share of the distances between numbers that occur often which may be smaller than the step of a sensor."""
ON_STEPS = 0.99
"""Least share of the readings that are multiples of the step, counted from the most frequent one."""
OFF = 0.03
"""Largest distance from a multiple, in steps: logs round numbers, too."""
NEAR = 8.0
"""Steps from the most frequent number within which a step is fitted first; then twice as far, and so on."""


@dataclass(frozen=True)
class CoarseSteps:
    """Steps of a force sensor that matter beside its noise.

    Parameters
    ----------
    steps : dict, name of a component -> float
        Steps, N.
    """

    steps: Mapping[str, float]

    @property
    def step(self) -> float:
        """The largest step, N."""
        return max(self.steps.values())

    @property
    def error(self) -> float:
        """Root mean square, N, of what rounding to the largest step changes."""
        return self.step / np.sqrt(12.0)

    @property
    def words(self) -> str:
        """What was found, as sentences for the user."""
        sizes = {name: quantity(step, "N") for name, step in self.steps.items()}
        if len(set(sizes.values())) == 1:
            told = f"{joined_names(list(sizes))} in steps of {quantity(self.step, 'N')}"
        else:
            told = joined_names([f"{name} in steps of {size}" for name, size in sizes.items()])
        return (
            f"The force sensor reads {told}. Readings are off by up to half a step,"
            f" {quantity(self.error, 'N')} in the root mean square. Log the sensor's full resolution."
        )

    @property
    def document(self) -> dict[str, object]:
        """The steps as they stand in ``diagnosis.json`` (schemas/diagnosis.json)."""
        return {"effect": "quantisation", "values": {"step": self.step}, "words": self.words}


def find_coarse_steps(readings: Sequence[Array]) -> CoarseSteps | None:
    """Return the steps that readings of a force sensor show; ``None`` where they show none that matters.

    Parameters
    ----------
    readings : sequence of (m, 6) N, N m
        Readings of each trajectory as they were logged, sensor's frame. Readings that are not finite are left out, and
        those that repeat the one before: a log may be faster than its sensor.
    """
    new = [_new_rows(rows[np.isfinite(rows).all(axis=1)]) for rows in readings]
    found = {}
    for column, name in enumerate(AXES):
        columns = [rows[:, column] for rows in new]
        values = np.concatenate([*columns, np.empty(0)])
        if len(values) < FEWEST:
            continue
        step = _fitted_step(values, step_of(values))
        rounding = step / np.sqrt(12.0)
        if rounding > LEAST_ERROR and rounding**2 >= LEAST_SHARE * _variance_of(columns):
            found[name] = step
    return CoarseSteps(found) if len(found) >= FEWEST_AXES else None


def step_of(column: Array) -> float:
    """Return the step between the numbers that occur in a component, in its unit; 0 where most numbers differ.

    Numbers that occur once are strays: a sensor that saturates puts some between the steps.

    Parameters
    ----------
    column : (m,) N or N m
        Readings of one component.
    """
    numbers, counts = np.unique(np.round(column, DIGITS), return_counts=True)
    is_often = counts > 1
    if is_often.sum() < 2 or 2 * counts[is_often].sum() < len(column):
        return 0.0
    # a bound is a number that occurs often, and is no step
    return float(np.quantile(np.diff(numbers[is_often]), STRAYS, method="lower"))


def _new_rows(rows: Array) -> Array:
    """Return the readings (m, 6) that differ from the one before."""
    is_new = np.ones(len(rows), dtype=bool)
    is_new[1:] = (np.diff(rows, axis=0) != 0).any(axis=1)
    return rows[is_new]


def _variance_of(columns: Sequence[Array]) -> float:
    """Return the variance of one component from reading to reading, by the smaller changes; infinite without any."""
    squares = np.sort(np.concatenate([*(np.diff(column) ** 2 for column in columns), np.empty(0)]))
    smaller = squares[: int(SLOWEST * len(squares))]
    return float(smaller.mean() / 2.0) if len(smaller) else float("inf")


def _fitted_step(column: Array, step: float) -> float:
    """Return the step of which nearly all readings are multiples, counted from one of them; 0 where there is none.

    A first step is the distance of two numbers, which a log has rounded. It is fitted to numbers ever farther away, so
    that no multiple is miscounted.

    Parameters
    ----------
    column : (m,) N
        Readings of one component.
    step : float
        First step, N; 0 for none.
    """
    if step <= 0:
        return 0.0
    numbers, counts = np.unique(np.round(column, DIGITS), return_counts=True)
    start = numbers[np.argmax(counts)]
    away, often = numbers - start, numbers[counts > 1] - start
    origin, reach = 0.0, NEAR
    while True:
        near = often[np.abs(often) <= reach * step]
        multiples = np.round((near - origin) / step)
        if len(np.unique(multiples)) > 1:
            step, origin = (float(number) for number in np.polyfit(multiples, near, 1))
        if step <= 0:
            return 0.0
        if reach * step >= np.abs(away).max():
            break
        reach *= 2.0
    off = (column - start - origin) / step
    return step if (np.abs(off - np.round(off)) <= OFF).mean() >= ON_STEPS else 0.0
