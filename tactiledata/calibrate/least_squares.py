"""The vector loss near its optimum: damped Gauss-Newton, covariance, and its inflation by trajectories that differ."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.losses import VectorLoss

STEP = 1e-4
"""Step of the finite differences, as a share of the box."""
ROUNDS = 30
"""Largest number of Gauss-Newton iterations."""
STILL = 1e-6
"""Largest change of a parameter, as a share of the box, at which the search ends."""


@dataclass(frozen=True)
class Optimum:
    """A minimum of the sum of squares.

    Parameters
    ----------
    shares : (3,)
        E, nu, mu as shares of the box.
    cost : float
        The sum of squares there.
    """

    shares: Array
    cost: float


def polish(loss: VectorLoss, bounds: Bounds, shares: Array, held: int | None = None) -> Optimum:
    """Minimise the vector loss by damped Gauss-Newton inside the box.

    Parameters
    ----------
    loss : VectorLoss
        Its residual is squared and summed.
    bounds : Bounds
        The box.
    shares : (3,)
        Start near the optimum, as shares of the box.
    held : int, optional
        Place of a parameter that stays at its start: 0 E, 1 nu, 2 mu.
    """
    adjustable = np.array([k for k in range(3) if k != held])
    current = np.clip(shares, 0.0, 1.0)
    residual = loss.residual(bounds.scaled(current))
    cost, damping = float(residual @ residual), 1e-6
    for _ in range(ROUNDS):
        slope = jacobian(loss, bounds, current, residual)
        gradient = slope.T @ residual
        # a parameter that stands at its bound and is driven beyond it is held there for this round
        outward = ((current <= 0.0) & (gradient > 0)) | ((current >= 1.0) & (gradient < 0))
        free = adjustable[~outward[adjustable]]
        if not len(free):
            break
        # damped step of the free parameters
        normal = slope[:, free].T @ slope[:, free]
        step = np.zeros(3)
        step[free] = -np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), gradient[free])
        # accept a step that does not raise the cost; otherwise damp more
        trial = np.clip(current + step, 0.0, 1.0)
        trial_residual = loss.residual(bounds.scaled(trial))
        if (trial_cost := float(trial_residual @ trial_residual)) <= cost:
            largest_step = float(np.abs(trial - current).max())
            current, residual, cost, damping = trial, trial_residual, trial_cost, max(damping / 10, 1e-9)
        else:
            largest_step, damping = float(np.abs(step).max()), damping * 30
        if largest_step < STILL or damping > 1e9:
            break
    return Optimum(current, cost)


def jacobian(loss: VectorLoss, bounds: Bounds, shares: Array, residual: Array) -> Array:
    """Derivative (m, 3) of the residual over shares of the box, by one-sided differences that stay inside the box.

    Parameters
    ----------
    loss : VectorLoss
        Gives the residual, profiled over offsets, zeros and factors.
    bounds : Bounds
        The box.
    shares : (3,)
        Where the derivative is taken.
    residual : (m,)
        The residual there.
    """
    columns = []
    for k in range(3):
        step = STEP if shares[k] <= 0.5 else -STEP
        shifted = shares.copy()
        shifted[k] += step
        columns.append((loss.residual(bounds.scaled(shifted)) - residual) / step)
    return np.stack(columns, axis=1)


@dataclass(frozen=True)
class Spread:
    """Covariance of E, nu and mu, in shares of the box, and the inflation of their variances.

    Parameters
    ----------
    covariance : (3, 3)
        Covariance that follows from the noise alone.
    inflation : (3,)
        Factor on the variance of each parameter for the disagreement of trajectories beyond the noise; at least 1.
    """

    covariance: Array
    inflation: Array

    @property
    def correlation(self) -> Array:
        """Correlation (3, 3) of the three estimates."""
        deviations = np.sqrt(np.diag(self.covariance))
        return self.covariance / np.outer(deviations, deviations)


def spread(loss: VectorLoss, bounds: Bounds, shares: Array) -> Spread:
    """Covariance at the optimum, and its inflation from a sandwich estimate over trajectories.

    Where the model is incomplete, residuals of one trajectory are correlated, and the noise alone makes intervals too
    narrow. The scatter of the scores of whole trajectories shows by how much (White 1982; the adjustment of the
    likelihood by Pace, Salvan and Sartori 2011). Agreement by chance makes no interval narrower, and with four
    trajectories or fewer nothing is inflated.

    Parameters
    ----------
    loss : VectorLoss
        Gives the residual and the trajectory of each of its entries.
    bounds : Bounds
        The box.
    shares : (3,)
        The optimum, as shares of the box.
    """
    residual = loss.residual(bounds.scaled(shares))
    slope = jacobian(loss, bounds, shares, residual)
    normal = slope.T @ slope
    covariance: Array = np.asarray(np.linalg.pinv(normal, rcond=1e-12), dtype=np.float64)
    # score of each trajectory: the sum of its rows of the gradient
    scores = np.zeros((len(loss.response.starts), 3))
    np.add.at(scores, loss.owner(), slope * residual[:, None])
    count = len(scores)
    if count <= 4:
        return Spread(covariance, np.ones(3))
    # three parameters were fitted: count / (count - 3) corrects the scatter for small samples
    score_scatter = scores.T @ scores * count / (count - 3)
    sandwich = covariance @ score_scatter @ covariance
    inflation = np.diag(sandwich) / np.maximum(np.diag(covariance), 1e-300)
    return Spread(covariance, np.maximum(inflation, 1.0))
