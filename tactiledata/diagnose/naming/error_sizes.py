"""Sizes of the simulation's errors, estimated from the data at hand instead of assumed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.touches.simulation_errors import FAMILIES
from tactiledata.diagnose.touches.whitened import WhitenedTouches

DOUBT = 0.7
"""Standard deviation of the logarithm of a size about 0: two solvers differ by 1 to 10 %, about 3 %."""
SMALLEST, LARGEST = 0.6, 4.0
"""Bounds of a size: errors below two per cent are not believed, and more than a tenth is no solver of the same gel."""


def with_estimated_sizes(whitened: WhitenedTouches, fit: JointFit) -> WhitenedTouches:
    """Return the trajectories with the sizes of the simulation's errors that the residual of a plain fit asks for.

    The sizes of the families maximise the marginal likelihood of the residual, to first order about the fit, times a
    log-normal prior (empirical Bayes). What else is missing from the simulation can only make them larger.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories, every size 1.
    fit : JointFit
        Plain fit to them.

    Source: MacKay, Neural Computation 4 (1992), the evidence for hyperparameters.
    """
    errors = whitened.simulation_errors
    first = len(fit.precision) - len(errors)
    family = np.array([FAMILIES.index(error.family) for error in errors])
    about = RandomEffects(fit.own, fit.shared[:, :, :0], fit.precision[:0], fit.starts)
    gram = about.products(fit.shared, fit.shared)
    toward = about.products(fit.shared, fit.residual_at_centre[:, :, None])[:, 0]

    def cost(logarithms: Array) -> float:
        """Twice the negative logarithm of marginal likelihood and prior, up to a constant."""
        precision = fit.precision.copy()
        precision[first:] = np.exp(-2.0 * logarithms)[family]
        posterior = gram + np.diag(precision)
        scale = np.sqrt(np.maximum(np.diag(posterior), 1e-300))
        scaled = posterior / np.outer(scale, scale)
        determinant = np.linalg.slogdet(scaled)[1] + 2.0 * np.log(scale).sum() - np.log(precision[first:]).sum()
        explained = float((toward / scale) @ np.linalg.lstsq(scaled, toward / scale, rcond=1e-12)[0])
        return float(determinant - explained + ((logarithms / DOUBT) ** 2).sum())

    bounds = [(np.log(SMALLEST), np.log(LARGEST))] * len(FAMILIES)
    found = minimize(cost, np.zeros(len(FAMILIES)), method="L-BFGS-B", bounds=bounds)
    sizes = dict(zip(FAMILIES, np.exp(found.x).tolist(), strict=True))
    return replace(whitened, errors=whitened.errors.with_sizes(sizes))
