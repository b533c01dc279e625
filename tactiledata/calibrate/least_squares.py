"""The vector loss near its optimum: least squares, curvature, and what trajectories agree on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.losses import VectorLoss

STEP = 1e-4
"""Share of the box, of differences."""
ROUNDS = 30
STILL = 1e-6
"""Share of the box: a step this small ends the search."""


@dataclass(frozen=True)
class Optimum:
    """A least sum of squares.

    Parameters
    ----------
    shares : (3,), of the box
    cost : the sum of squares
    """

    shares: Array
    cost: float


def polish(loss: VectorLoss, bounds: Bounds, shares: Array, held: int | None = None) -> Optimum:
    """Damped Gauss-Newton inside the box from a start near the optimum; one parameter may be held."""
    moving = np.array([k for k in range(3) if k != held])
    here = np.clip(shares, 0.0, 1.0)
    residual = loss.residual(bounds.scaled(here))
    cost, damping = float(residual @ residual), 1e-6
    for _ in range(ROUNDS):
        slope = jacobian(loss, bounds, here, residual)
        gradient = slope.T @ residual
        # a parameter that stands at its bound and is driven beyond it is held there for this round
        outward = ((here <= 0.0) & (gradient > 0)) | ((here >= 1.0) & (gradient < 0))
        free = moving[~outward[moving]]
        if not len(free):
            break
        normal = slope[:, free].T @ slope[:, free]
        step = np.zeros(3)
        step[free] = -np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), gradient[free])
        tried = np.clip(here + step, 0.0, 1.0)
        other = loss.residual(bounds.scaled(tried))
        if (reached := float(other @ other)) <= cost:
            moved = float(np.abs(tried - here).max())
            here, residual, cost, damping = tried, other, reached, max(damping / 10, 1e-9)
        else:
            moved, damping = float(np.abs(step).max()), damping * 30
        if moved < STILL or damping > 1e9:
            break
    return Optimum(here, cost)


def jacobian(loss: VectorLoss, bounds: Bounds, shares: Array, residual: Array) -> Array:
    """Change (m, 3) of the profiled residual (m,) over shares of the box; differences towards its inside."""
    columns = []
    for k in range(3):
        step = STEP if shares[k] <= 0.5 else -STEP
        there = shares.copy()
        there[k] += step
        columns.append((loss.residual(bounds.scaled(there)) - residual) / step)
    return np.stack(columns, axis=1)


@dataclass(frozen=True)
class Spread:
    """How well the three parameters are known together, in shares of the box.

    Parameters
    ----------
    covariance : (3, 3)
        As the noise has it.
    inflation : (3,)
        Factor on the variance of each: what trajectories, each on its own, disagree on beyond the noise.
    """

    covariance: Array
    inflation: Array

    @property
    def correlation(self) -> Array:
        """(3, 3)."""
        deviations = np.sqrt(np.diag(self.covariance))
        return self.covariance / np.outer(deviations, deviations)


def spread(loss: VectorLoss, bounds: Bounds, shares: Array) -> Spread:
    """Covariance at the optimum, and the sandwich of trajectories' scores about it.

    Where the model is not the whole truth, residuals of one trajectory hang together, and the noise alone makes
    intervals too narrow: the scores of whole trajectories tell by how much (White 1982; the adjustment of the
    likelihood by Pace, Salvan and Sartori 2011). Agreement by chance makes no interval narrower.
    """
    residual = loss.residual(bounds.scaled(shares))
    slope = jacobian(loss, bounds, shares, residual)
    normal = slope.T @ slope
    covariance: Array = np.asarray(np.linalg.pinv(normal, rcond=1e-12), dtype=np.float64)
    scores = np.zeros((len(loss.response.starts), 3))
    np.add.at(scores, loss.owner(), slope * residual[:, None])
    count = len(scores)
    if count <= 4:
        return Spread(covariance, np.ones(3))
    meat = scores.T @ scores * count / (count - 3)
    sandwich = covariance @ meat @ covariance
    inflation = np.diag(sandwich) / np.maximum(np.diag(covariance), 1e-300)
    return Spread(covariance, np.maximum(inflation, 1.0))
