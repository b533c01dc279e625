"""What mesh and solver leave of error in forces; a common factor on all forces is a factor on Young's modulus."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FORCE_ERROR = {"finite-strain": 0.03, "linear": 0.12, "mujoco-flex": 0.3}
"""Standard deviation, as a share: against converged reference solutions finite strain is 2 to 4 % off on the low mesh,
linear 10 to 20 % at 1 mm depth (docs/calibration.md), and MuJoCo's tetrahedra 25 to 40 % too stiff (docs/gel.md)."""

SCATTER = 0.01
"""Standard deviation, as a share of the force: by how much frame by frame the solver's tolerance, patches that come and
go under a rim, and the grid of responses move a simulated force."""


def frame_weights(forces: Array, noise: float, scatter: float = SCATTER) -> Array:
    """Weights (n,) of frames whose simulated forces scatter beside the noise of the measured ones.

    Parameters
    ----------
    forces : (n, 3) N
    noise : N, standard deviation of one component
    scatter : share of the force
    """
    return 1.0 / np.sqrt(1.0 + (scatter * np.linalg.norm(forces, axis=1) / noise) ** 2)


def with_force_error(value: float, interval: tuple[float, float], share: float) -> tuple[float, float]:
    """The interval of a modulus, widened on both sides for a common error of all forces.

    Parameters
    ----------
    share : standard deviation of the error, relative
    """
    more = 1.96 * share * value
    low, high = (float(np.hypot(value - interval[0], more)), float(np.hypot(interval[1] - value, more)))
    return value - low, value + high
