"""Folds over units of exchange, for what learns from residuals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.residuals.residuals import Residuals

FOLDS = 5
"""Number of folds in which units of exchange are held out."""


def folds(residuals: Residuals, seed: int, count: int = FOLDS) -> NDArray[np.int64]:
    """Return the fold number (n,) of each frame, drawn at random; all frames of a unit of exchange share one fold.

    Parameters
    ----------
    residuals : Residuals
        The n frames and their units of exchange.
    seed : int
        Random seed of the draw.
    count : int
        Number of folds; fewer where there are fewer units.
    """
    units = residuals.unit_count
    dealt = np.random.default_rng(seed).permutation(np.arange(units) % min(count, units))
    return dealt[residuals.unit_of_trajectory][residuals.trajectory].astype(np.int64)
