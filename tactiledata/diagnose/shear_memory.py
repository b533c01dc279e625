"""What a shift along the gel that differs from frame to frame does to shear: friction remembers the way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def shear_change(path: Array, shift: Array, stiffness: Array, limit: Array) -> Array:
    """Change (n, 2) of the force on an indenter that is shifted by (n, 2) from a path (n, 2), m.

    Both ways are followed by a spring that slides at a limit (n,); a shift that stays the same changes nothing.
    Stiffness (n,) and limit are over one modulus, and 0 without contact.
    """
    if not np.ptp(shift, axis=0).any():
        return np.zeros_like(path)
    half = 0.5 * (stiffness[1:] + stiffness[:-1])
    change: Array = _followed(path, half, limit) - _followed(path + shift, half, limit)
    return change


def _followed(path: Array, between: Array, limit: Array) -> Array:
    """Pull (n, 2) on the gel; stiffness (n - 1,) between frames."""
    steps = [[0.0, 0.0], *((path[1:] - path[:-1]) * between[:, None]).tolist()]
    pull = np.zeros_like(path)
    x = y = 0.0
    for frame, most in enumerate(limit.tolist()):
        if not most > 0.0:
            x = y = 0.0
            continue
        x, y = x + steps[frame][0], y + steps[frame][1]
        size = (x * x + y * y) ** 0.5
        if size > most:
            x, y = x * most / size, y * most / size
        pull[frame] = x, y
    return pull
