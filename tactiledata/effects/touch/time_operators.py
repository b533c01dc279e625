"""What time does to a wrench that is known frame by frame and straight between frames."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array


def fading_memory(seconds: Array, wrench: Array, time: float) -> Array:
    """The part of a wrench (n, 6) that is not yet forgotten: the integral of exp(-(t - s) / time) dF(s).

    Exact for a wrench that is straight between frames; the past before the first frame is forgotten. Rows that are NaN
    are passed over and stay NaN.
    """
    known = np.isfinite(wrench).all(axis=1)
    memory = np.full_like(wrench, np.nan)
    memory[known] = _memory(seconds[known], wrench[known], time)
    return memory


def _memory(seconds: Array, wrench: Array, time: float) -> Array:
    memory = np.zeros_like(wrench)
    steps = zip(*fading_steps(seconds, time), np.diff(wrench, axis=0), strict=True)
    for frame, (fade, gain, change) in enumerate(steps):
        memory[frame + 1] = fade * memory[frame] + gain * change
    return memory


def fading_steps(seconds: Array, time: float) -> tuple[Array, Array]:
    """What is left of a memory after each span between n moments, and what a change in it adds, both (n - 1,)."""
    spans = np.diff(seconds)
    return np.exp(-spans / time), -np.expm1(-spans / time) * (time / spans)


def delayed(seconds: Array, wrench: Array, delay: Array | float) -> Array:
    """The wrench (n, 6) as it was ``delay`` seconds earlier, straight between frames and held at both ends."""
    known = np.isfinite(wrench).all(axis=1)
    if not known.any():
        return wrench
    at = (seconds - delay)[known]
    late = np.full_like(wrench, np.nan)
    late[known] = np.stack([np.interp(at, seconds[known], column) for column in wrench[known].T], axis=1)
    return late
