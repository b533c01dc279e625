"""How well the trajectories agree on an effect: the signature statistic."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.metric import RandomEffects

LARGEST_LEVERAGE = 0.98
"""Limits the leverage of one trajectory in the jackknife: a trajectory that alone decides agrees with no other."""


@dataclass(frozen=True)
class Agreement:
    """The share of an effect's change that the residual holds, and how well the trajectories agree on it.

    A gain is a square: its spread over trajectories is mostly that of how much each trajectory can show. Here each
    trajectory weighs as much as it can show, and the error measures how far the trajectories disagree.

    Parameters
    ----------
    share : float
        1 where the residual holds all of the change, 0 where it holds none.
    error : float
        Standard error of the share over trajectories.
    """

    share: float
    error: float

    @property
    def standard_errors(self) -> float:
        """Signature statistic: the share divided by its standard error; 0 where there is no error."""
        return self.share / self.error if self.error > 0 else 0.0


def agreement(metric: RandomEffects, change: Array, residual: Array) -> Agreement:
    """Return the regression coefficient of a residual on an effect's change, with its error over trajectories.

    With r the residual, d the change, M the metric and (Md)_k the rows of trajectory k: a_k = (Md)_kᵀ r_k,
    b_k = (Md)_kᵀ d_k, share s = Σ a_k / Σ b_k, leverage h_k = b_k / Σ b_k, and the squared standard error is
    Σ ((a_k - b_k s) / (1 - h_k))² / (Σ b_k)². Both are 0 where nothing of the change is left in the metric.

    Parameters
    ----------
    metric : RandomEffects
        What a refit can imitate counts for nothing in it.
    change, residual : (N, 6)
        Whitened.

    Source: MacKinnon and White, Journal of Econometrics 29 (1985), HC3, here of trajectories.
    """
    weighed = metric.weigh(change[:, :, None])[:, :, 0]
    scores = np.add.reduceat((weighed * residual).sum(axis=1), metric.starts)
    squares = np.add.reduceat((weighed * change).sum(axis=1), metric.starts)
    total = float(squares.sum())
    if not total > 0:
        return Agreement(0.0, 0.0)
    share = float(scores.sum()) / total
    # a trajectory pulls the share towards its own noise: dividing by 1 - leverage undoes that, as in a jackknife
    leverage = np.clip(squares / total, 0.0, LARGEST_LEVERAGE)
    spread = float((((scores - squares * share) / (1.0 - leverage)) ** 2).sum())
    return Agreement(share, float(np.sqrt(max(spread, 1e-300))) / total)
