"""Intervals widened for the simulation's own errors: one of all forces alike, one of the force law's exponent."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array
from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.least_squares import polish
from tactiledata.calibrate.losses import NormLoss, VectorLoss
from tactiledata.calibrate.search import descend
from tactiledata.nuisance.numerical import FORCE_ERROR, LAW_ERROR, with_law_error

QUANTILE = 1.96
"""Standard deviations of a normal distribution at the ends of a 95 % interval."""


@dataclass(frozen=True)
class SimulationError:
    """Errors by which two simulations of the same gel differ, and the intervals that allow for them.

    Parameters
    ----------
    force, law : float
        Standard deviations, as shares: of all forces alike, and of a force relative to one that is e times smaller.
    ends : (3, 2)
        95 % intervals that include these errors, Pa for E; inside the bounds.
    """

    force: float
    law: float
    ends: Array


def simulation_error(
    loss: VectorLoss | NormLoss, bounds: Bounds, optimum: Array, ends: Array, mechanics: str
) -> SimulationError:
    """Widen the ends of intervals in quadrature by the known errors of the simulation.

    An error of all forces alike is a factor on E. For the force law, the measured wrenches are bent by plus and minus
    its 95 % and fitted again; how far the optimum moves widens each side, which differ where nu is near 0.5.

    Parameters
    ----------
    loss : VectorLoss or NormLoss
        The loss that was minimised.
    bounds : Bounds
        The box; widened intervals end at it.
    optimum : (3,)
        E (Pa), nu, mu that minimise the loss.
    ends : (3, 2)
        95 % intervals from the data alone.
    mechanics : str
        Engine and fidelity, a key of ``FORCE_ERROR`` and ``LAW_ERROR``.
    """
    force, law = FORCE_ERROR[mechanics], LAW_ERROR[mechanics]
    bent_losses = (replace(loss, measured=with_law_error(loss.measured, sign * QUANTILE * law)) for sign in (-1, 1))
    optima = np.array([optimum, *(_refitted(bent_loss, bounds, optimum) for bent_loss in bent_losses)])
    # distances from the optimum to both ends, by each cause
    by_law = np.stack([optimum - optima.min(axis=0), optima.max(axis=0) - optimum], axis=1)
    by_force = np.array([QUANTILE * force * optimum[0], 0.0, 0.0])[:, None]
    reach = np.sqrt((ends - optimum[:, None]) ** 2 + by_law**2 + by_force**2)
    widened = np.stack([optimum - reach[:, 0], optimum + reach[:, 1]], axis=1)
    inside = np.clip(widened, np.asarray(bounds.low)[:, None], np.asarray(bounds.high)[:, None])
    return SimulationError(force, law, inside)


def _refitted(loss: VectorLoss | NormLoss, bounds: Bounds, start: Array) -> Array:
    """Return the minimum (3,) of a loss near a start: Gauss-Newton for the vector loss, else Subplex."""
    if isinstance(loss, VectorLoss):
        return bounds.scaled(polish(loss, bounds, bounds.shares(start)).shares)
    return descend(loss, bounds, start)
