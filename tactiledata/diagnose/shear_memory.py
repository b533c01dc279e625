"""What a shift along the gel that differs from frame to frame does to shear: friction remembers the way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.sliders import Sliders

Array = NDArray[np.float64]


def shear_change(path: Array, shift: Array, stiffness: Array, limit: Array, sliders: Sliders) -> Array:
    """Change (n, 2) of the force on an indenter that is shifted by (n, 2) from a path (n, 2), m.

    Both ways are followed by springs that slide at a limit (n,); a shift that stays the same changes nothing.
    Stiffness (n,) and limit are over one modulus, and 0 without contact.
    """
    if not (shift != shift[:1]).any():
        return np.zeros_like(path)
    change: Array = sliders.pull(path, stiffness, limit) - sliders.pull(path + shift, stiffness, limit)
    return change
