"""Time since the last step of a covariate that is held at levels, as a load is: what a creep follows."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.dimensions import find_unit
from tactiledata.diagnose.residuals.residuals import Covariate, Indices

TIME_EXPONENTS = (0.0, 0.0, 1.0, *[0.0] * 4)
BEYOND = 8.0
"""Standard deviations of the jitter at a level that a step is larger than."""
SMALLEST_STEP = 0.02
"""Share of a covariate's range, where it is held without jitter."""
OF_NORMAL = 1.4826
"""Standard deviation of a normal law over its median absolute value."""
FEWEST_ROWS = 5
"""Rows of a hold."""
HELD = 0.5
"""Share of the rows, and of the groups, that must be in holds, or have a step."""
STILL = 8.0
"""Sizes of a step over the median distance from a hold's median: of a ramp it is 4."""
MOST = 2
"""Times since steps; with so many no further covariate is looked at."""
NOT_ZERO = " while it is not 0"
IN_MINUTES = 60.0
"""s: times are in minutes where the longest is longer."""


def times_since_steps(covariates: Mapping[str, Covariate], starts: Indices, time: str | None) -> dict[str, Covariate]:
    """The time since the last step of each covariate that is held at levels, by its name, in s or min.

    Empty where no covariate is the time, or the unit of the time is not known.

    Parameters
    ----------
    covariates : dict, name -> Covariate
        Frames of one trajectory lie together, in order of time.
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
    seconds = covariates[time].values * unit.factor
    found: dict[str, Covariate] = {}
    known = [seconds - np.repeat(seconds[starts], np.diff(starts, append=len(seconds)))]
    for name, covariate in covariates.items():
        if name == time:
            continue
        size = step_size(covariate.values, starts)
        begins = step_rows(covariate.values, starts, size)
        if not is_held(covariate.values, starts, begins, size):
            continue
        since = seconds - np.repeat(seconds[begins], np.diff(begins, append=len(seconds)))
        definition = _meant(name, covariate.unit, size)
        away = f"{definition}; it is 0 in rows where {name} lies no more than that from 0"
        # a spring without a load does not creep; whether it creeps back is for the data to say
        is_away = np.abs(covariate.values) > size
        for steps_of, times, meant in ((name, since, definition), (f"{name}{NOT_ZERO}", since * is_away, away)):
            if times.max() > 0 and not any(np.allclose(times, other) for other in known):
                known.append(times)
                said, factor = ("min", 60.0) if times.max() > IN_MINUTES else ("s", 1.0)
                found[f"time since the last step of {steps_of}"] = Covariate(times / factor, said, meant, steps_of)
        if len(found) >= MOST:
            break
    return found


def step_size(values: Array, starts: Indices) -> float:
    """Return by how much a covariate must change to have made a step: far more than it jitters from row to row."""
    changes = np.abs(np.delete(np.diff(values), starts[1:] - 1))
    jitter = OF_NORMAL * float(np.median(changes)) / np.sqrt(2.0) if len(changes) else 0.0
    return max(BEYOND * jitter, SMALLEST_STEP * float(np.ptp(values)))


def step_rows(values: Array, starts: Indices, size: float) -> Indices:
    """Rows (s,) of the steps, and the first of each trajectory: farther than a size from the mean since the last."""
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
    """Whether a covariate rests at levels between its steps, and most trajectories have steps."""
    if not size > 0:
        return False
    has_step = np.diff(np.searchsorted(begins, [*starts, len(values)])) > 1
    lengths = np.diff(begins, append=len(values))
    is_hold = np.repeat(lengths >= FEWEST_ROWS, lengths)
    if has_step.mean() < HELD or is_hold.mean() < HELD:
        return False
    middles = np.repeat([np.median(part) for part in np.split(values, begins[1:])], lengths)
    return bool(np.median(np.abs(values - middles)[is_hold]) * STILL <= size)


def _meant(name: str, unit: str, size: float) -> str:
    in_unit = "" if unit in ("", "1", "?") else f" {unit}"
    return (
        f"counted from the last step of {name}; a row is a step where {name} lies more than {size:.3g}{in_unit} from "
        "its mean over the rows from the last step on up to the row before, in order of time; the first row of a group "
        "counts as one"
    )
