"""The library that trees, boosting and Gaussian processes come from, which the base install does not have."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.errors import TactileDataError


def need_learning_library() -> None:
    """Nothing, where it is installed.

    Raises
    ------
    TactileDataError
        It is not.
    """
    if find_spec("sklearn") is None:
        raise TactileDataError(
            "the package 'scikit-learn' is not installed", "it, for a diagnosis", "pip install 'tactiledata[models]'"
        )


FOLDS = 5


def folds(residuals: Residuals, seed: int, count: int = FOLDS) -> NDArray[np.int64]:
    """Fold (n,) of each frame; frames of one unit of exchange share theirs."""
    units = residuals.unit_count
    dealt = np.random.default_rng(seed).permutation(np.arange(units) % min(count, units))
    return dealt[residuals.unit_of_trajectory][residuals.trajectory].astype(np.int64)
