"""How well the trajectories agree on an effect: the signature statistic, and whether its strength changes with time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array, Indices
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


def strength_trend(
    metric: RandomEffects, change: Array, residual: Array, seconds: Array, indenter: Indices
) -> Agreement | None:
    """Return by which share of itself an effect is stronger in the last trajectories than in the middle of the session.

    The residual is that of a fit in which the effect has one strength. It is regressed on the effect's change times
    the trajectory's time, which runs from -1 for the first to 1 for the last. A strength of its own for each indenter
    counts for nothing, since errors of a simulation differ by indenter, but cannot know the time.

    Parameters
    ----------
    metric : RandomEffects
        What a refit of all other numbers can imitate counts for nothing in it.
    change, residual : (N, 6)
        Whitened; what the fitted effect changes, and what the fit leaves.
    seconds : (t,) s
        Time of each trajectory since the sensor was switched on.
    indenter : (t,)
        Number of the indenter of each trajectory.

    Returns
    -------
    Agreement, optional
        Its share s says that the effect has 1 + s times its strength in the last trajectory, and 1 - s times in the
        first. ``None`` where all trajectories have the same time, or times that are not known.
    """
    low, high = float(seconds.min()), float(seconds.max())
    if not high > low:
        return None
    counts = np.diff(metric.starts, append=len(change))
    late = np.repeat((2.0 * seconds - low - high) / (high - low), counts)[:, None] * change
    of_row = np.repeat(indenter, counts)
    own = np.stack([change * (of_row == number)[:, None] for number in np.unique(indenter)], axis=2)
    # both without the shares of indenters, in the metric (Frisch, Waugh and Lovell)
    both = np.stack([late, residual], axis=2)
    left = both - own @ (np.linalg.pinv(metric.products(own, own), hermitian=True) @ metric.products(own, both))
    return agreement(metric, left[:, :, 0], left[:, :, 1])
