"""How wrong a predicted force is, by axis and in its norm, in newtons.

Each sample gives its absolute errors: their mean is the MAE, their root mean square the RMSE.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from tactiledata.metrics.base import Score, Values, metric, number_pairs

AXES = ("n", "3")
COMPONENTS = ("fx", "fy", "fz")


def component_error(axis: int, predicted: Any, true: Any, mask: Any = None) -> Values:
    """Absolute error (n,), N, of one component."""
    ours, theirs = number_pairs(predicted, true, AXES)
    return np.abs(ours - theirs)[:, axis]


def norm_error(predicted: Any, true: Any, mask: Any = None) -> Values:
    """Absolute difference (n,), N, of the norms."""
    ours, theirs = number_pairs(predicted, true, AXES)
    return np.abs(np.linalg.norm(ours, axis=1) - np.linalg.norm(theirs, axis=1))


def root_mean_square(errors: Any) -> float:
    """RMSE, N, of absolute errors (n,); hand it to ``bootstrap`` as its statistic."""
    return float(np.sqrt(np.square(np.asarray(errors, np.float64)).mean()))


FORCE_ERROR = metric(
    "force_error",
    "how wrong a force is; forces (n, 3) N",
    "forces",
    [
        *(
            Score(name, f"|error of {name}|", "N", "lower", 0.0, partial(component_error, axis))
            for axis, name in enumerate(COMPONENTS)
        ),
        Score("norm", "|error of ||F||₂|", "N", "lower", 0.0, norm_error),
    ],
)
