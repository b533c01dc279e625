"""Whether trajectories agree that a change is there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.random_effects import RandomEffects

Array = NDArray[np.float64]

MOST_ALONE = 0.98
"""Of what all tell, that one trajectory is taken to tell at most: one alone agrees with nobody."""


@dataclass(frozen=True)
class Agreement:
    """How much of a change there is, as trajectories say.

    A gain is a square, so that its spread over trajectories is mostly that of how much each can tell; here each weighs
    as much as it can tell, and the error is what they disagree by.

    Parameters
    ----------
    share : float
        Of the change, that is in the residual: 1 where all of it is, 0 where none.
    error : float
        Its standard error over trajectories.
    """

    share: float
    error: float

    @property
    def standard_errors(self) -> float:
        """By how many of them the share is not 0."""
        return self.share / self.error if self.error > 0 else 0.0


def agreement(metric: RandomEffects, change: Array, residual: Array) -> Agreement:
    """A change (N, 6) against a residual (N, 6), both whitened, beyond what the metric's refit imitates.

    Source: MacKinnon and White, Journal of Econometrics 29 (1985), HC3, here of trajectories.
    """
    weighed = metric.weigh(change[:, :, None])[:, :, 0]
    scores = np.add.reduceat((weighed * residual).sum(axis=1), metric.starts)
    told = np.add.reduceat((weighed * change).sum(axis=1), metric.starts)
    total = float(told.sum())
    if not total > 0:
        return Agreement(0.0, 0.0)
    share = float(scores.sum()) / total
    # what one trajectory tells is partly its own noise: the share without it, as in a jackknife
    alone = np.clip(told / total, 0.0, MOST_ALONE)
    spread = float((((scores - told * share) / (1.0 - alone)) ** 2).sum())
    return Agreement(share, float(np.sqrt(max(spread, 1e-300))) / total)
