"""Memory and delay of a wrench that is known at frames and linear between them."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array


def fading_memory(seconds: Array, wrench: Array, time: float) -> Array:
    """Fading memory (n, 6) of a wrench F: the integral of exp(-(t - s) / time) dF(s).

    Exact for a wrench that is linear between frames. It starts at 0 in the first frame. Rows that are NaN are passed
    over and stay NaN.

    Parameters
    ----------
    seconds : (n,) s, ascending
        Times of the frames.
    wrench : (n, 6) N, N m
        The wrench F.
    time : float
        Time constant, s.
    """
    known = np.isfinite(wrench).all(axis=1)
    memory = np.full_like(wrench, np.nan)
    memory[known] = _memory(seconds[known], wrench[known], time)
    return memory


def _memory(seconds: Array, wrench: Array, time: float) -> Array:
    """Fading memory (n, 6) of a wrench without NaN."""
    memory = np.zeros_like(wrench)
    steps = zip(*fading_steps(seconds, time), np.diff(wrench, axis=0), strict=True)
    for frame, (fade, gain, change) in enumerate(steps):
        memory[frame + 1] = fade * memory[frame] + gain * change
    return memory


def fading_steps(seconds: Array, time: float) -> tuple[Array, Array]:
    """Factors (n - 1,) on the memory over each span between n times, and on the change of the wrench in the span."""
    spans = np.diff(seconds)
    return np.exp(-spans / time), -np.expm1(-spans / time) * (time / spans)


def delayed(seconds: Array, wrench: Array, delay: Array | float) -> Array:
    """Return the wrench (n, 6) as it was ``delay`` seconds earlier, linear between frames and held at both ends.

    Parameters
    ----------
    seconds : (n,) s, ascending
        Times of the frames.
    wrench : (n, 6) N, N m
        The wrench; rows that are NaN stay NaN.
    delay : float or (n,)
        Delay of each frame, s; negative for a wrench that comes early.
    """
    known = np.isfinite(wrench).all(axis=1)
    if not known.any():
        return wrench
    at = (seconds - delay)[known]
    late = np.full_like(wrench, np.nan)
    late[known] = np.stack([np.interp(at, seconds[known], column) for column in wrench[known].T], axis=1)
    return late
