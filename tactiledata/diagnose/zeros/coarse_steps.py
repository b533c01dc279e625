"""Whether a force sensor reads in coarse steps: the distances between the numbers that it logs.

A sensor or its driver rounds a load to a multiple of a step. Steps far below the noise do not matter. Coarse ones add
to the noise, and hide small changes. The readings are those of the log: an offset, a rotation or a weight that was
taken off would hide the step.
"""

from __future__ import annotations

from collections.abc import Sequence
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
OFF = 0.01
"""Largest distance from a multiple, in steps."""


@dataclass(frozen=True)
class CoarseSteps:
    """Steps of a force sensor that matter beside its noise.

    Parameters
    ----------
    step : float
        Step, N: the median of the components that show one.
    axes : tuple of str
        Components that show it.
    """

    step: float
    axes: tuple[str, ...]

    @property
    def error(self) -> float:
        """Root mean square, N, of what rounding to the step changes."""
        return self.step / np.sqrt(12.0)

    @property
    def words(self) -> str:
        """What was found, as sentences for the user."""
        return (
            f"The force sensor reads {joined_names(self.axes)} in steps of {quantity(self.step, 'N')}. Readings are off"
            f" by up to half a step, {quantity(self.error, 'N')} in the root mean square. Log the sensor's full"
            " resolution."
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
        Readings of each trajectory as they were logged, sensor's frame; readings that are not finite are left out.
    """
    finite = [rows[np.isfinite(rows).all(axis=1)] for rows in readings]
    found = {}
    for column, name in enumerate(AXES):
        columns = [rows[:, column] for rows in finite]
        values = np.concatenate([*columns, np.empty(0)])
        if len(values) < FEWEST:
            continue
        step = step_of(values)
        rounding = step / np.sqrt(12.0)
        matters = rounding > LEAST_ERROR and rounding**2 >= LEAST_SHARE * _variance_of(columns)
        if matters and _is_on_steps(values, step):
            found[name] = step
    return CoarseSteps(float(np.median(list(found.values()))), tuple(found)) if len(found) >= FEWEST_AXES else None


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


def _variance_of(columns: Sequence[Array]) -> float:
    """Return the variance of one component from reading to reading, by the smaller changes between them."""
    squares = np.sort(np.concatenate([*(np.diff(column) ** 2 for column in columns), np.empty(0)]))
    return float(squares[: int(SLOWEST * len(squares))].mean() / 2.0)


def _is_on_steps(column: Array, step: float) -> bool:
    """Return whether nearly all readings of a component are multiples of a step, counted from the most frequent one."""
    numbers, counts = np.unique(np.round(column, DIGITS), return_counts=True)
    away = (column - numbers[np.argmax(counts)]) / step
    return bool((np.abs(away - np.round(away)) <= OFF).mean() >= ON_STEPS)
