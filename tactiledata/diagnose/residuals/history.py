"""What a covariate was before, as materials remember it: its largest value so far, and memories that fade."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array, Indices


def largest_so_far(values: Array, starts: Indices) -> Array:
    """The running maximum (n,) inside each trajectory."""
    parts = np.split(values, starts[1:])
    return np.concatenate([np.maximum.accumulate(part) for part in parts])


def fading_memory(values: Array, seconds: Array, starts: Indices, fading: float) -> Array:
    """What is left (n,) of all changes of a covariate, each faded for the time since.

    ``m(t) = sum of change(s) exp(-(t - s) / fading)``: a Maxwell element's force under a strain that goes with the
    covariate. It begins at the covariate's first value.

    Parameters
    ----------
    values, seconds : (n,)
        Times ascend inside each trajectory.
    starts : (t,)
        First row of each trajectory.
    fading : float
        In the unit of the times.
    """
    memory = values.copy()
    counts = np.diff(starts, append=len(values))
    for later in range(1, int(counts.max(initial=0))):
        rows = starts[counts > later] + later
        kept = np.exp(-(seconds[rows] - seconds[rows - 1]) / fading)
        memory[rows] = memory[rows - 1] * kept + (values[rows] - values[rows - 1])
    return memory
