"""Whole units of exchange dealt out to folds: what measures an improvement has not chosen it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.residuals import Residuals

FOLDS = 5


def folds(residuals: Residuals, seed: int, count: int = FOLDS) -> NDArray[np.int64]:
    """Fold (n,) of each frame; frames of one unit of exchange share theirs."""
    units = residuals.unit_count
    dealt = np.random.default_rng(seed).permutation(np.arange(units) % min(count, units))
    return dealt[residuals.unit_of_trajectory][residuals.trajectory].astype(np.int64)
