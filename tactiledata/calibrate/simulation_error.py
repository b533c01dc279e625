"""Intervals that allow for the simulation's own errors, too: of all forces alike, and of the force law."""

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


@dataclass(frozen=True)
class SimulationError:
    """What two simulations of the same gel differ in, and the intervals that it leaves.

    Parameters
    ----------
    force, law : standard deviations, as shares
        Of all forces alike, and of forces over e times smaller ones.
    ends : (3, 2)
        95 % intervals with it, Pa for E; inside the bounds.
    """

    force: float
    law: float
    ends: Array


def simulation_error(
    loss: VectorLoss | NormLoss, bounds: Bounds, optimum: Array, ends: Array, mechanics: str
) -> SimulationError:
    """The intervals' ends (3, 2), widened in quadrature by what the simulation is known to be off.

    All forces alike: a factor on E. The force law: measurements that grow with the force by the 95 % of it more, and
    less, are fitted anew, and the optimum moves, farther to one side than to the other where nu is near 0.5.

    Parameters
    ----------
    optimum : (3,)
        E (Pa), nu, mu, of the loss.
    mechanics : key of ``FORCE_ERROR`` and ``LAW_ERROR``
    """
    force, law = FORCE_ERROR[mechanics], LAW_ERROR[mechanics]
    bent = (replace(loss, measured=with_law_error(loss.measured, sign * QUANTILE * law)) for sign in (-1, 1))
    moved = np.array([optimum, *(_refitted(other, bounds, optimum) for other in bent)])
    by_law = np.stack([optimum - moved.min(axis=0), moved.max(axis=0) - optimum], axis=1)
    by_force = np.array([QUANTILE * force * optimum[0], 0.0, 0.0])[:, None]
    reach = np.sqrt((ends - optimum[:, None]) ** 2 + by_law**2 + by_force**2)
    wide = np.stack([optimum - reach[:, 0], optimum + reach[:, 1]], axis=1)
    inside = np.clip(wide, np.asarray(bounds.low)[:, None], np.asarray(bounds.high)[:, None])
    return SimulationError(force, law, inside)


def _refitted(loss: VectorLoss | NormLoss, bounds: Bounds, start: Array) -> Array:
    if isinstance(loss, VectorLoss):
        return bounds.scaled(polish(loss, bounds, bounds.shares(start)).shares)
    return descend(loss, bounds, start)
