"""Sizes of the simulation's errors, estimated from the data at hand instead of assumed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.parameters import JointModel
from tactiledata.diagnose.touches.simulation_errors import FAMILIES
from tactiledata.diagnose.touches.whitened import WhitenedTouches

DOUBT = 0.7
"""Standard deviation of the logarithm of a size about 0: two solvers differ by 1 to 10 %, about 3 %."""
INFLUENCE = 1e-14
"""Information on a fitted number, as a share of the largest one, below which it counts as having no influence."""
SMALLEST, LARGEST = 0.6, 4.0
"""Bounds of a size. No two solvers agree better than to about 2 %; where they differ by far more than a tenth, one of
them does not simulate this gel."""


def with_estimated_sizes(whitened: WhitenedTouches, fit: JointFit) -> WhitenedTouches:
    """Return the trajectories with the sizes of the simulation's errors that make the residual of a fit most likely.

    The sizes of the families maximise the marginal likelihood of the residual, to first order about the fit, times a
    log-normal prior (empirical Bayes). What is missing from the fitted model can only make them larger.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories.
    fit : JointFit
        Fit to them.

    Source: MacKay, Neural Computation 4 (1992), the evidence for hyperparameters.
    """
    cost = _size_cost(whitened, fit)
    bounds = [(np.log(SMALLEST), np.log(LARGEST))] * len(FAMILIES)
    found = minimize(cost, np.log(_sizes(whitened)), method="L-BFGS-B", bounds=bounds)
    sizes = dict(zip(FAMILIES, np.exp(found.x).tolist(), strict=True))
    return replace(whitened, errors=whitened.errors.with_sizes(sizes))


def size_penalty(whitened: WhitenedTouches, fit: JointFit, other: WhitenedTouches) -> float:
    """Return by how much the logarithm of a fit's marginal likelihood falls with other sizes of errors; at least 0.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories with the sizes of the fit.
    fit : JointFit
        Fit to them.
    other : WhitenedTouches
        The same trajectories with other sizes.
    """
    cost = _size_cost(whitened, fit)
    return max(0.0, 0.5 * (cost(np.log(_sizes(other))) - cost(np.log(_sizes(whitened)))))


def with_errors_of(model: JointModel, before: WhitenedTouches, after: WhitenedTouches) -> JointModel:
    """Return a model with its errors of the simulation in new units, so that they remain the same wrenches.

    Parameters
    ----------
    model : JointModel
        Its errors are in standard deviations of ``before``; those returned are in standard deviations of ``after``.
    before, after : WhitenedTouches
        The same trajectories with the sizes before and after the change.
    """
    pairs = zip(before.simulation_errors, after.simulation_errors, strict=True)
    return replace(model, errors=model.errors * np.array([old.deviation / new.deviation for old, new in pairs]))


def smallest_ratio(before: WhitenedTouches, after: WhitenedTouches) -> float:
    """Return the smallest ratio of a size after a change to that before it."""
    return float((_sizes(after) / _sizes(before)).min())


def _sizes(whitened: WhitenedTouches) -> Array:
    """Sizes of the families (3,)."""
    return np.array([whitened.errors.size(family) for family in FAMILIES])


def _size_cost(whitened: WhitenedTouches, fit: JointFit) -> Callable[[Array], float]:
    """Twice the negative logarithm of marginal likelihood and prior, a function of the sizes' logarithms (3,)."""
    errors, now = whitened.simulation_errors, np.log(_sizes(whitened))
    first = len(fit.precision) - len(errors)
    family = np.array([FAMILIES.index(error.family) for error in errors])
    about = RandomEffects(fit.own, fit.shared[:, :, :0], fit.precision[:0], fit.starts)
    gram = about.products(fit.shared, fit.shared)
    toward = about.products(fit.shared, fit.residual_at_centre[:, :, None])[:, 0]
    # a number with neither influence nor prior (the time constant of an absent effect) is no evidence on the sizes
    is_known = (np.diag(gram) > INFLUENCE * np.diag(gram).max()) | (fit.precision > 0)
    gram, toward, known_precision = gram[np.ix_(is_known, is_known)], toward[is_known], fit.precision[is_known]
    first -= int((~is_known[:first]).sum())

    def cost(logarithms: Array) -> float:
        precision = known_precision.copy()
        precision[first:] = np.exp(-2.0 * (logarithms - now))[family]
        posterior = gram + np.diag(precision)
        scale = np.sqrt(np.maximum(np.diag(posterior), 1e-300))
        scaled = posterior / np.outer(scale, scale)
        determinant = np.linalg.slogdet(scaled)[1] + 2.0 * np.log(scale).sum() - np.log(precision[first:]).sum()
        explained = float((toward / scale) @ np.linalg.lstsq(scaled, toward / scale, rcond=1e-12)[0])
        return float(determinant - explained + ((logarithms / DOUBT) ** 2).sum())

    return cost
