"""A smooth surface over two covariates, for structure that has no formula: not explained, do not extrapolate."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.learners import folds, need_learning_library
from tactiledata.diagnose.residuals.projection import ProjectedResiduals

LABEL = "not explained, do not extrapolate"
MOST_POINTS = 250


@dataclass(frozen=True)
class Empirical:
    """A Gaussian process for each component.

    Parameters
    ----------
    covariates : the two names
    low, high : (2,)
        The box that was seen; outside it nothing is predicted.
    explained : float
        Share of the squares of trajectories that were held out, not below 0.
    processes : one for each component, ``None`` where it is no better than 0
    """

    covariates: tuple[str, str]
    low: Array
    high: Array
    explained: float
    processes: tuple[Any, ...]

    @property
    def words(self) -> str:
        """With its label."""
        over = " and ".join(self.covariates)
        return f"A smooth surface over {over} takes {100 * self.explained:.0f} % of the squares: {LABEL}."

    def predict(self, places: Array) -> Array:
        """Whitened residuals (m, k) at places (m, 2); NaN outside the box."""
        is_inside = np.logical_and(places >= self.low, places <= self.high).all(axis=1)
        scaled = (places - self.low) / (self.high - self.low)
        columns = [np.zeros(len(places)) if one is None else one.predict(scaled) for one in self.processes]
        return np.where(np.asarray(is_inside)[:, None], np.column_stack(columns), np.nan)


def empirical(projection: ProjectedResiduals, covariates: tuple[str, str], seed: int = 0) -> Empirical | None:
    """The surface over two covariates, or ``None`` where one of them hardly varies."""
    need_learning_library()
    residuals = projection.residuals
    places = np.column_stack([residuals.covariates[name].values for name in covariates])
    low, high = places.min(axis=0), places.max(axis=0)
    if not (high > low).all():
        return None
    scaled = (places - low) / (high - low)
    fold = folds(residuals, seed)
    processes, taken, total = [], 0.0, float((projection.score**2).sum())
    for column in range(projection.score.shape[1]):
        values = projection.score[:, column]
        rows = _thinned(len(values), seed)
        process = _fitted(scaled[rows], values[rows])
        gain = 0.0
        for number in np.unique(fold):
            train, test = rows[fold[rows] != number], np.flatnonzero(fold == number)
            apart = _fitted(scaled[train], values[train], process.kernel_)
            gain += float((values[test] ** 2).sum() - ((values[test] - apart.predict(scaled[test])) ** 2).sum())
        processes.append(process if gain > 0 else None)
        taken += max(gain, 0.0)
    return Empirical(covariates, low, high, taken / max(total, 1e-300), tuple(processes))


def _thinned(count: int, seed: int) -> NDArray[np.int64]:
    """Rows that the process learns from: its work grows with their cube."""
    chosen = np.random.default_rng(seed).permutation(count)[:MOST_POINTS]
    return np.sort(chosen).astype(np.int64)


def _fitted(places: Array, values: Array, kernel: Any = None) -> Any:
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    variance = max(float(values.var()), 1e-12)
    start = ConstantKernel(variance, (1e-4 * variance, 1e3 * variance)) * RBF([0.3, 0.3], (0.05, 10.0)) + WhiteKernel(
        variance, (1e-3 * variance, 1e2 * variance)
    )
    process = GaussianProcessRegressor(
        start if kernel is None else kernel, optimizer=None if kernel is not None else "fmin_l_bfgs_b"
    )
    with warnings.catch_warnings():
        # a kernel at its bound is a surface that is flat along one covariate
        warnings.simplefilter("ignore", ConvergenceWarning)
        return process.fit(places, values)
