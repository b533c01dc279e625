"""Functions of a covariate's past: its running maximum, and an exponentially fading memory of its changes."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array, Indices


def largest_so_far(values: Array, starts: Indices) -> Array:
    """Return the running maximum (n,) of a covariate inside each trajectory; ``starts`` (t,) are their first rows."""
    parts = np.split(values, starts[1:])
    return np.concatenate([np.maximum.accumulate(part) for part in parts])


def fading_memory(values: Array, seconds: Array, starts: Indices, fading: float) -> Array:
    """Return the exponentially fading memory (n,) of a covariate's changes, in the covariate's unit.

    ``m(t) = sum of change(s) exp(-(t - s) / fading)``: the force of a Maxwell element whose strain is proportional to
    the covariate. In each trajectory it begins at the covariate's first value.

    Parameters
    ----------
    values : (n,)
        The covariate.
    seconds : (n,)
        Times, ascending inside each trajectory.
    starts : (t,)
        First row of each trajectory.
    fading : float
        Time constant, in the unit of the times.
    """
    memory = values.copy()
    counts = np.diff(starts, append=len(values))
    # the recursion runs over frames, and over all trajectories at once that are long enough
    for frame in range(1, int(counts.max(initial=0))):
        rows = starts[counts > frame] + frame
        kept = np.exp(-(seconds[rows] - seconds[rows - 1]) / fading)
        memory[rows] = memory[rows - 1] * kept + (values[rows] - values[rows - 1])
    return memory
