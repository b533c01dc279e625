"""Errors of a predicted force, N, by axis and in its norm.

The values are absolute errors of samples: their mean is the MAE, their root mean square the RMSE.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from tactiledata.metrics.base import Score, Values, metric, number_pairs

AXES = ("n", "3")
"""Axes of a batch of forces."""
COMPONENTS = ("fx", "fy", "fz")
"""Names of the components of a force, in order."""


def component_error(axis: int, predicted: Any, true: Any, mask: Any = None) -> Values:
    """Absolute error (n,), N, of one component of the force.

    Parameters
    ----------
    axis : int
        Number of the component, 0 to 2.
    predicted, true : (n, 3), N
        Forces, sample by sample.
    mask : ignored
        Forces have no mask.
    """
    ours, theirs = number_pairs(predicted, true, AXES)
    return np.abs(ours - theirs)[:, axis]


def norm_error(predicted: Any, true: Any, mask: Any = None) -> Values:
    """Absolute difference (n,), N, of the norms of the forces.

    Parameters
    ----------
    predicted, true : (n, 3), N
        Forces, sample by sample.
    mask : ignored
        Forces have no mask.
    """
    ours, theirs = number_pairs(predicted, true, AXES)
    return np.abs(np.linalg.norm(ours, axis=1) - np.linalg.norm(theirs, axis=1))


def root_mean_square(errors: Any) -> float:
    """Root mean square, N, of absolute errors (n,); a statistic for ``bootstrap``."""
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
