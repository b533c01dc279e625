"""Time since the last step of a covariate that is held at levels, such as a load: creep depends on this time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.dimensions import find_unit
from tactiledata.diagnose.residuals.residuals import Covariate, Indices

TIME_EXPONENTS = (0.0, 0.0, 1.0, *[0.0] * 4)
"""Dimension of a time, as exponents of `tactiledata.diagnose.residuals.dimensions`."""
BEYOND = 8.0
"""Least size of a step, in standard deviations of the jitter from row to row."""
SMALLEST_STEP = 0.02
"""Least size of a step as a share of the covariate's range; it decides where there is no jitter."""
OF_NORMAL = 1.4826
"""Standard deviation of a normal distribution over its median absolute value."""
FEWEST_ROWS = 5
"""Fewest rows of a hold."""
HELD = 0.5
"""Least share of rows that lie in holds, and least share of trajectories that have a step."""
STILL = 8.0
"""Least ratio of the step size to the median distance from a hold's median; a ramp has a ratio of 4."""
MOST = 2
"""Most new covariates: once there are as many, no further covariate is examined."""
NOT_ZERO = " while it is not 0"
"""End of the name of a time that counts only while the held covariate is not 0."""
IN_MINUTES = 60.0
"""Longest time in s that is given in seconds; longer ones are given in minutes."""


def times_since_steps(covariates: Mapping[str, Covariate], starts: Indices, time: str | None) -> dict[str, Covariate]:
    """Return new covariates, by name: times, s or min, since the last step of covariates that are held at levels.

    The result is empty where no covariate is the time, or where the unit of the time is not known.

    Parameters
    ----------
    covariates : dict, name -> Covariate
        Covariates of all n frames; frames of one trajectory lie together, in order of time.
    starts : (t,)
        First row of each trajectory.
    time : str, optional
        The covariate that is the time inside a trajectory.
    """
    if time is None or time not in covariates:
        return {}
    unit = find_unit(covariates[time].unit)
    if unit is None or unit.exponents != TIME_EXPONENTS:
        return {}
    # a time that equals one already known, such as the time since the trajectory's start, is no new covariate
    seconds = covariates[time].values * unit.factor
    added: dict[str, Covariate] = {}
    known = [seconds - np.repeat(seconds[starts], np.diff(starts, append=len(seconds)))]
    for name, covariate in covariates.items():
        if name == time:
            continue
        size = step_size(covariate.values, starts)
        begins = step_rows(covariate.values, starts, size)
        if not is_held(covariate.values, starts, begins, size):
            continue
        since = seconds - np.repeat(seconds[begins], np.diff(begins, append=len(seconds)))
        definition = _definition(name, covariate.unit, size)
        definition_away = f"{definition}; it is 0 in rows where {name} lies no more than that from 0"
        # without a load there is no creep, but there may be recovery: both times are offered, and the data decide
        is_away = np.abs(covariate.values) > size
        for steps_of, times, definition_of in (
            (name, since, definition),
            (f"{name}{NOT_ZERO}", since * is_away, definition_away),
        ):
            if times.max() > 0 and not any(np.allclose(times, other) for other in known):
                known.append(times)
                unit_name, factor = ("min", 60.0) if times.max() > IN_MINUTES else ("s", 1.0)
                added[f"time since the last step of {steps_of}"] = Covariate(
                    times / factor, unit_name, definition_of, steps_of
                )
        if len(added) >= MOST:
            break
    return added


def step_size(values: Array, starts: Indices) -> float:
    """Return the least change of a covariate that counts as a step, in its unit: far more than its jitter."""
    changes = np.abs(np.delete(np.diff(values), starts[1:] - 1))
    jitter = OF_NORMAL * float(np.median(changes)) / np.sqrt(2.0) if len(changes) else 0.0
    return max(BEYOND * jitter, SMALLEST_STEP * float(np.ptp(values)))


def step_rows(values: Array, starts: Indices, size: float) -> Indices:
    """Return rows (s,) at which holds begin: the first of each trajectory, and each that starts a step.

    A row starts a step where it differs by more than ``size`` from the mean since the last step.

    Parameters
    ----------
    values : (n,)
        The covariate.
    starts : (t,)
        First row of each trajectory.
    size : float
        Least size of a step, as from `step_size`.
    """
    begins: list[int] = []
    for start, stop in zip(starts, [*starts[1:], len(values)], strict=True):
        total, count = 0.0, 0
        for row in range(int(start), int(stop)):
            value = float(values[row])
            if not count or abs(value - total / count) > size:
                begins.append(row)
                total, count = 0.0, 0
            total, count = total + value, count + 1
    return np.array(begins, dtype=np.int64)


def is_held(values: Array, starts: Indices, begins: Indices, size: float) -> bool:
    """Return whether a covariate rests at levels between its steps, and at least half of the trajectories have a step.

    Parameters
    ----------
    values : (n,)
        The covariate.
    starts : (t,)
        First row of each trajectory.
    begins : (s,)
        Rows at which holds begin, as from `step_rows`.
    size : float
        Least size of a step, as from `step_size`.
    """
    if not size > 0:
        return False
    has_step = np.diff(np.searchsorted(begins, [*starts, len(values)])) > 1
    lengths = np.diff(begins, append=len(values))
    is_hold = np.repeat(lengths >= FEWEST_ROWS, lengths)
    if has_step.mean() < HELD or is_hold.mean() < HELD:
        return False
    middles = np.repeat([np.median(part) for part in np.split(values, begins[1:])], lengths)
    return bool(np.median(np.abs(values - middles)[is_hold]) * STILL <= size)


def _definition(name: str, unit: str, size: float) -> str:
    """Return how the time since the last step of a covariate is computed, in words for the report."""
    in_unit = "" if unit in ("", "1", "?") else f" {unit}"
    return (
        f"counted from the last step of {name}; a row is a step where {name} lies more than {size:.3g}{in_unit} from "
        "its mean over the rows from the last step on up to the row before, in order of time; the first row of a group "
        "counts as a step"
    )
