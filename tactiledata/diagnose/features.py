"""Covariates and labels as columns of numbers, for learners that ask for no more."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.residuals import Residuals

Array = NDArray[np.float64]


def features(residuals: Residuals) -> Array:
    """Columns (n, f): covariates as they are, labels by number."""
    columns = [one.values for one in residuals.covariates.values()]
    columns += [np.unique(texts, return_inverse=True)[1].astype(np.float64) for texts in residuals.labels.values()]
    return np.column_stack(columns) if columns else np.zeros((len(residuals.values), 0))
