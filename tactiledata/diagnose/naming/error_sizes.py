"""Sizes of the simulation's errors, estimated from the data at hand instead of assumed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

from tactiledata.arrays import Array, Indices
from tactiledata.diagnose.naming.joint_fit import JointFit, joint_fit
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.own_error_sizes import own_size_penalty, with_estimated_own_sizes
from tactiledata.diagnose.naming.parameters import JointModel
from tactiledata.diagnose.residuals.scaled_matrix import scaled_matrix
from tactiledata.diagnose.touches.simulation_errors import FAMILIES
from tactiledata.diagnose.touches.whitened import WhitenedTouches

DOUBT = 0.7
"""Standard deviation of the logarithm of a family's usual size about 0: two solvers differ by 1 to 10 %, about 3 %."""
SPREAD = 0.7
"""Standard deviation of the logarithm of a size under one indenter about its family's usual one: two solvers agree on a
ball and not on the edge of a punch."""
TURNS = 2
"""How often the sizes of shared errors and of those of single touches are estimated in turn."""
INFLUENCE = 1e-14
"""Information on a fitted number, as a share of the largest one, below which it counts as having no influence."""
SMALLEST, LARGEST = 0.6, 4.0
"""Bounds of a size. No two solvers agree better than to about 2 %; where they differ by far more than a tenth, one of
them does not simulate this gel."""


def with_estimated_errors(
    whitened: WhitenedTouches, fit: JointFit, fitted: Callable[..., JointFit] = joint_fit
) -> tuple[WhitenedTouches, JointFit]:
    """Return the trajectories with all sizes of errors estimated from the residual of a plain fit, and the fit to them.

    A size is a factor on standard deviations: `NumericalErrors.sizes` of errors that touches share, `OwnErrors.sizes`
    of those of single touches. The two compete for the same residual: they are estimated in turn, ``TURNS`` times, each
    time with a new fit without effects.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories.
    fit : JointFit
        Fit to them, without effects.
    fitted : callable
        Makes the new fits, as `joint_fit`.
    """
    for _ in range(TURNS):
        whitened = with_simulated_by(whitened, fit)
        for estimated in (with_estimated_sizes, with_estimated_own_sizes):
            before, whitened = whitened, estimated(whitened, fit)
            fit = fitted(whitened, with_errors_of(fit.model, before, whitened))
    return whitened, fit


def with_simulated_by(whitened: WhitenedTouches, fit: JointFit) -> WhitenedTouches:
    """Return the trajectories with errors in proportion to the wrenches of a fit."""
    model = fit.model
    return whitened.with_simulated(whitened.touch_set.play(model.material, model.settings, model.offsets))


def with_estimated_sizes(whitened: WhitenedTouches, fit: JointFit) -> WhitenedTouches:
    """Return the trajectories with the sizes of the simulation's errors that make the residual of a fit most likely.

    There is one size for each family and indenter (`NumericalErrors.sizes`), from ``SMALLEST`` to ``LARGEST``. They
    maximise the marginal likelihood of the residual, to first order about the fit, times a hierarchical log-normal
    prior (empirical Bayes): sizes of a family are alike. What is missing from the fitted model can only make them
    larger.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories.
    fit : JointFit
        Fit to them.

    Source: MacKay, Neural Computation 4 (1992), the evidence for hyperparameters.
    """
    return replace(whitened, errors=whitened.errors.with_sizes(estimated_sizes(whitened, fit)))


def estimated_sizes(whitened: WhitenedTouches, fit: JointFit) -> dict[tuple[str, str], float]:
    """Return the sizes that `with_estimated_sizes` gives the errors, by family and indenter.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories.
    fit : JointFit
        Fit to them.
    """
    cost = _size_cost(whitened, fit)
    start = np.log(_sizes(whitened))
    bounds = [(np.log(SMALLEST), np.log(LARGEST))] * len(start)
    found = minimize(cost, np.clip(start, *bounds[0]), jac=True, method="L-BFGS-B", bounds=bounds)
    return dict(zip(_groups(whitened), np.exp(found.x).tolist(), strict=True))


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
    of_shared = max(0.0, 0.5 * (cost(np.log(_sizes(other)))[0] - cost(np.log(_sizes(whitened)))[0]))
    return of_shared + own_size_penalty(whitened, fit, other.own.sizes or {})


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
    """Return the smallest ratio of a size after a change to that before it, of shared errors and of single touches."""
    of_touches = [after.own.size(name) / before.own.size(name) for name in before.indenter_names]
    return float(min((_sizes(after) / _sizes(before)).min(), *of_touches))


def typical_size(sizes: Mapping[tuple[str, str], float]) -> float:
    """Return the geometric mean of sizes of errors; 1 is what two solvers usually differ by, and where there are none.

    Parameters
    ----------
    sizes : dict, (family, indenter) -> size
        See `estimated_sizes`.
    """
    return float(np.exp(np.log(list(sizes.values())).mean())) if sizes else 1.0


def _groups(whitened: WhitenedTouches) -> list[tuple[str, str]]:
    """Family and indenter of each size; the indenter is empty for errors that all have in common."""
    return list(dict.fromkeys((error.family, error.indenter) for error in whitened.simulation_errors))


def _sizes(whitened: WhitenedTouches) -> Array:
    """Sizes (g,) of the groups of errors."""
    return np.array([whitened.errors.size(*group) for group in _groups(whitened)])


def _size_cost(whitened: WhitenedTouches, fit: JointFit) -> Callable[[Array], tuple[float, Array]]:
    """Twice the negative logarithm of marginal likelihood and prior, and its gradient.

    Both are functions of the logarithms (g,) of the sizes.
    """
    errors, now = whitened.simulation_errors, np.log(_sizes(whitened))
    groups = _groups(whitened)
    of_error = np.array([groups.index((error.family, error.indenter)) for error in errors])
    of_family = np.array([FAMILIES.index(family) for family, _ in groups])
    first = len(fit.precision) - len(errors)
    about = RandomEffects(fit.own, fit.shared[:, :, :0], fit.precision[:0], fit.starts)
    gram = about.products(fit.shared, fit.shared)
    toward = about.products(fit.shared, fit.residual_at_centre[:, :, None])[:, 0]
    # what rounding alone leaves on the diagonal is no influence: the prior stands alone there
    is_felt = scaled_matrix(gram).has_information
    gram, toward = np.where(np.outer(is_felt, is_felt), gram, 0.0), np.where(is_felt, toward, 0.0)
    # a number with neither influence nor prior (the time constant of an absent effect) is no evidence on the sizes
    is_known = (np.diag(gram) > INFLUENCE * np.diag(gram).max()) | (fit.precision > 0)
    gram, toward, known_precision = gram[np.ix_(is_known, is_known)], toward[is_known], fit.precision[is_known]
    first -= int((~is_known[:first]).sum())

    def cost(logarithms: Array) -> tuple[float, Array]:
        precision = known_precision.copy()
        precision[first:] = np.exp(-2.0 * (logarithms - now))[of_error]
        scaled = scaled_matrix(gram + np.diag(precision))
        covariance, determinant = scaled.pseudo_inverse(1e-12), scaled.log_determinant
        mean = covariance @ toward
        determinant -= np.log(precision[first:]).sum()
        # d/dp of ln det(G + P) - ln p - gᵀ (G + P)⁻¹ g is C_ii - 1 / p + m_i², and dp/dl is -2 p
        slopes = -2.0 * (precision * (np.diag(covariance) + mean**2) - 1.0)[first:]
        prior, of_prior = _size_prior(logarithms, of_family)
        return float(determinant - toward @ mean + prior), np.bincount(of_error, slopes, len(groups)) + of_prior

    return cost


def _size_prior(logarithms: Array, of_family: Indices) -> tuple[float, Array]:
    """Twice the negative logarithm of the prior of sizes, and its gradient (g,); each family's usual size maximises it.

    Parameters
    ----------
    logarithms : (g,)
        Logarithms of the sizes.
    of_family : (g,)
        Number of each one's family.
    """
    counts = np.bincount(of_family)
    usual = np.bincount(of_family, logarithms) / SPREAD**2 / (counts / SPREAD**2 + 1.0 / DOUBT**2)
    off = (logarithms - usual[of_family]) / SPREAD
    # the gradient over a usual size is 0 where it maximises the prior
    return float((off**2).sum() + ((usual / DOUBT) ** 2).sum()), 2.0 * off / SPREAD
