"""Global minimum of a loss inside the bounds, with nlopt: DIRECT-L over the whole box, then Subplex downhill."""

from __future__ import annotations

import nlopt
import numpy as np

from tactiledata.arrays import Array
from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.least_squares import polish
from tactiledata.calibrate.losses import Loss, VectorLoss

GLOBAL_EVALUATIONS = 300
"""Most evaluations of the loss by DIRECT-L."""
LOCAL_EVALUATIONS = 1500
"""Most evaluations of the loss by each Subplex search."""
PRECISION = 1e-6
"""Change of the parameters, relative to the box, at which a search ends."""
ROUGH = 1e-2
"""Change of the parameters, relative to the box, at which a search ends whose result Gauss-Newton improves."""


def search(loss: Loss, bounds: Bounds, start: Array) -> Array:
    """Return E (Pa), nu, mu (3,) of the smallest loss in the box.

    DIRECT-L divides the box deterministically; Subplex then descends from its best point and from ``start``.

    Parameters
    ----------
    loss : Loss
        Minimised.
    bounds : Bounds
        The box.
    start : (3,)
        E (Pa), nu, mu of a first guess.
    """
    global_best = _minimise(loss, bounds, start, nlopt.GN_DIRECT_L, GLOBAL_EVALUATIONS)
    candidates = [descend(loss, bounds, place) for place in (global_best, start)]
    return min(candidates, key=loss.value)


def search_squares(loss: VectorLoss, bounds: Bounds, start: Array) -> Array:
    """Return E (Pa), nu, mu (3,) of the smallest sum of squares in the box.

    As `search`, but Subplex only comes near, and Gauss-Newton ends both descents.

    Parameters
    ----------
    loss : VectorLoss
        Its residual is squared and summed.
    bounds : Bounds
        The box.
    start : (3,)
        E (Pa), nu, mu of a first guess.
    """
    global_best = _minimise(loss, bounds, start, nlopt.GN_DIRECT_L, GLOBAL_EVALUATIONS)
    near = [_minimise(loss, bounds, place, nlopt.LN_SBPLX, LOCAL_EVALUATIONS, ROUGH) for place in (global_best, start)]
    optima = [polish(loss, bounds, bounds.shares(place)) for place in near]
    return bounds.scaled(min(optima, key=lambda optimum: optimum.cost).shares)


def descend(loss: Loss, bounds: Bounds, start: Array) -> Array:
    """Return the local minimum E (Pa), nu, mu (3,) that Subplex reaches from a start.

    Parameters
    ----------
    loss : Loss
        Minimised.
    bounds : Bounds
        The box.
    start : (3,)
        E (Pa), nu, mu.
    """
    return _minimise(loss, bounds, start, nlopt.LN_SBPLX, LOCAL_EVALUATIONS)


def _minimise(
    loss: Loss, bounds: Bounds, start: Array, algorithm: int, evaluations: int, precision: float = PRECISION
) -> Array:
    """Return the minimum (3,) that an nlopt algorithm reaches from a start, in shares of the box internally."""
    optimiser = nlopt.opt(algorithm, 3)
    optimiser.set_lower_bounds(np.zeros(3))
    optimiser.set_upper_bounds(np.ones(3))
    optimiser.set_maxeval(evaluations)
    optimiser.set_xtol_rel(precision)
    optimiser.set_min_objective(lambda shares, _gradient: loss.value(bounds.scaled(shares)))
    if algorithm == nlopt.LN_SBPLX:
        optimiser.set_initial_step(np.full(3, 0.1))
    # a start exactly on a bound would leave Subplex no room on one side
    first = np.clip(bounds.shares(bounds.inside(start)), 1e-6, 1 - 1e-6)
    return bounds.scaled(np.asarray(optimiser.optimize(first)))
