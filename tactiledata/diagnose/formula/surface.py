"""A smooth surface over two covariates: shows structure that has no formula, and predicts nothing outside its box."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.contract.extras import need_packages
from tactiledata.diagnose.residuals.learners import folds
from tactiledata.diagnose.residuals.projection import ProjectedResiduals

LABEL = "not explained, do not extrapolate"
MOST_POINTS = 250
"""Most rows to which a Gaussian process is fitted: its work grows with their cube."""


@dataclass(frozen=True)
class Empirical:
    """Gaussian processes over two covariates, one for each component of the residuals.

    Parameters
    ----------
    covariates : (str, str)
        Names of the two covariates.
    low, high : (2,)
        Range of the data; outside it nothing is predicted.
    explained : float
        Share of the squares of held-out trajectories that the surface explains, not below 0.
    processes : tuple
        Gaussian process of each component; ``None`` where it predicts held-out rows no better than 0.
    """

    covariates: tuple[str, str]
    low: Array
    high: Array
    explained: float
    processes: tuple[Any, ...]

    @property
    def words(self) -> str:
        """The surface in a sentence, with its label."""
        over = " and ".join(self.covariates)
        return f"A smooth surface over {over} takes {100 * self.explained:.0f} % of the squares: {LABEL}."

    def predict(self, places: Array) -> Array:
        """Return whitened residuals (m, k) at values (m, 2) of the covariates; NaN outside the box."""
        is_inside = np.logical_and(places >= self.low, places <= self.high).all(axis=1)
        scaled = (places - self.low) / (self.high - self.low)
        columns = [np.zeros(len(places)) if process is None else process.predict(scaled) for process in self.processes]
        return np.where(np.asarray(is_inside)[:, None], np.column_stack(columns), np.nan)


def empirical(projection: ProjectedResiduals, covariates: tuple[str, str], seed: int = 0) -> Empirical | None:
    """Return the surface over two covariates, or ``None`` where one of them does not vary.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals after the refit of the shared parameters.
    covariates : (str, str)
        Names of the two covariates.
    seed : int
        Draws the folds, and the rows to which the processes are fitted.

    Raises
    ------
    TactileDataError
        scikit-learn is not installed.
    """
    need_packages("a diagnosis", "sklearn")
    residuals = projection.residuals
    places = np.column_stack([residuals.covariates[name].values for name in covariates])
    low, high = places.min(axis=0), places.max(axis=0)
    if not (high > low).all():
        return None
    scaled = (places - low) / (high - low)
    fold = folds(residuals, seed)
    processes, explained, total = [], 0.0, float((projection.score**2).sum())
    for column in range(projection.score.shape[1]):
        values = projection.score[:, column]
        rows = _thinned(len(values), seed)
        process = _fitted(scaled[rows], values[rows])
        gain = 0.0
        for number in np.unique(fold):
            # of the held-out fold only the kernel, which all rows chose, knows anything
            train, test = rows[fold[rows] != number], np.flatnonzero(fold == number)
            refit = _fitted(scaled[train], values[train], process.kernel_)
            gain += float((values[test] ** 2).sum() - ((values[test] - refit.predict(scaled[test])) ** 2).sum())
        processes.append(process if gain > 0 else None)
        explained += max(gain, 0.0)
    return Empirical(covariates, low, high, explained / max(total, 1e-300), tuple(processes))


def _thinned(count: int, seed: int) -> NDArray[np.int64]:
    """Return the row numbers to which a process is fitted, at most `MOST_POINTS`, ascending."""
    chosen = np.random.default_rng(seed).permutation(count)[:MOST_POINTS]
    return np.sort(chosen).astype(np.int64)


def _fitted(places: Array, values: Array, kernel: Any = None) -> Any:
    """Return a Gaussian process fitted to values (r,) at places (r, 2); a given kernel is kept as it is."""
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
        # a kernel parameter at its bound only means that the surface is flat along one covariate
        warnings.simplefilter("ignore", ConvergenceWarning)
        return process.fit(places, values)
