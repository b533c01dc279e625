"""What a shift along the gel that differs from frame to frame does to shear: friction remembers the way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def shear_stiffness(area: Array, poisson_ratio: float, thickness: float) -> Array:
    """Tangential stiffness (n,), m, over Young's modulus, of round contacts (n,), m^2, on a bonded layer.

    A half-space (Mindlin: 8 G a / (2 - nu)) and a thin layer (G A / h) side by side, each right in its own limit.
    """
    modulus = 0.5 / (1.0 + poisson_ratio)
    stiffness: Array = 8.0 * modulus * np.sqrt(area / np.pi) / (2.0 - poisson_ratio) + modulus * area / thickness
    return stiffness


def shear_change(path: Array, shift: Array, stiffness: Array, limit: Array) -> Array:
    """Change (n, 2) of the force on an indenter that is shifted by (n, 2) from a path (n, 2), m.

    Both ways are followed by a spring that slides at a limit (n,); a shift that stays the same changes nothing.
    Stiffness (n,) and limit are over one modulus, and 0 without contact.
    """
    if not np.ptp(shift, axis=0).any():
        return np.zeros_like(path)
    change: Array = _followed(path, stiffness, limit) - _followed(path + shift, stiffness, limit)
    return change


def _followed(path: Array, stiffness: Array, limit: Array) -> Array:
    """Pull (n, 2) on the gel."""
    half = 0.5 * (stiffness + np.roll(stiffness, 1))
    steps = (np.diff(path, axis=0, prepend=path[:1]) * half[:, None]).tolist()
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


def friction_change(path: Array, stiffness: Array, limit: Array, changed: Array) -> Array:
    """Change (n, 2) of the force on an indenter on a path (n, 2), m, whose limit (n,) of sliding is another at times.

    What slid further at one frame is missing in the shear that sticks after it.
    """
    if (limit == changed).all():
        return np.zeros_like(path)
    change: Array = _followed(path, stiffness, limit) - _followed(path, stiffness, changed)
    return change
