"""The least loss inside the bounds: nlopt, the whole box first, then downhill from the best place."""

from __future__ import annotations

import nlopt
import numpy as np

from tactiledata.arrays import Array
from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.losses import Loss

GLOBAL_EVALUATIONS = 300
LOCAL_EVALUATIONS = 1500
PRECISION = 1e-6
"""Share of the box within which the optimum is found."""


def search(loss: Loss, bounds: Bounds, start: Array) -> Array:
    """E (Pa), nu, mu of the least loss (3,).

    DIRECT-L divides the box, without chance; Subplex then goes downhill from the best place and from ``start``.
    """
    found = _minimise(loss, bounds, start, nlopt.GN_DIRECT_L, GLOBAL_EVALUATIONS)
    candidates = [descend(loss, bounds, place) for place in (found, start)]
    return min(candidates, key=loss.value)


def descend(loss: Loss, bounds: Bounds, start: Array) -> Array:
    """Downhill from a start (3,)."""
    return _minimise(loss, bounds, start, nlopt.LN_SBPLX, LOCAL_EVALUATIONS)


def _minimise(loss: Loss, bounds: Bounds, start: Array, algorithm: int, evaluations: int) -> Array:
    seeker = nlopt.opt(algorithm, 3)
    seeker.set_lower_bounds(np.zeros(3))
    seeker.set_upper_bounds(np.ones(3))
    seeker.set_maxeval(evaluations)
    seeker.set_xtol_rel(PRECISION)
    seeker.set_min_objective(lambda shares, _gradient: loss.value(bounds.scaled(shares)))
    if algorithm == nlopt.LN_SBPLX:
        seeker.set_initial_step(np.full(3, 0.1))
    first = np.clip(bounds.shares(bounds.inside(start)), 1e-6, 1 - 1e-6)
    return bounds.scaled(np.asarray(seeker.optimize(first)))
