"""The share of the residual that boosted trees predict from the covariates: a ceiling for every formula."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from tactiledata.arrays import Array
from tactiledata.contract.extras import need_packages
from tactiledata.diagnose.residuals.learners import folds
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import Residuals


def features(residuals: Residuals) -> Array:
    """Return features (n, f) of each frame: covariates in their units, then each label as the number of its level."""
    columns = [covariate.values for covariate in residuals.covariates.values()]
    columns += [np.unique(texts, return_inverse=True)[1].astype(np.float64) for texts in residuals.labels.values()]
    return np.column_stack(columns) if columns else np.zeros((len(residuals.values), 0))


LEVEL = 0.01
"""Largest p-value at which the trees count as certain; small beside the 5 % that the locators share."""
WORTH = 0.02
"""Least share of held-out squares that trees or a surface must explain to be reported.

A formula must close this share of their gap to the floor.
"""
TREES = 60
"""Trees of each boosted model."""
LEAVES = 12
"""Most leaves of a tree."""


@dataclass(frozen=True)
class BlackBox:
    """Held-out predictions of the residual by boosted trees, and how much of it they explain.

    Parameters
    ----------
    predicted : (n, k)
        Predicted residual, in the unit that `Residuals.scale` names, by trees that were grown on other units of
        exchange; all 0 where the predictions would increase the sum of squares.
    squares : (u,)
        Sum of squares of each unit of exchange after the predictions are subtracted, with each trajectory's own
        parameters at their most likely values.
    explained : float
        Share of the sum of squares that the predictions remove, 0 to 1.
    p : float
        p-value of the agreement between residuals and predictions.
    """

    predicted: Array
    squares: Array
    explained: float
    p: float

    @property
    def is_certain(self) -> bool:
        """Whether the trees explain at least `WORTH` of the squares, at the level `LEVEL`."""
        return self.explained >= WORTH and self.p <= LEVEL


def black_box(projection: ProjectedResiduals, seed: int = 0) -> BlackBox:
    """Fit boosted trees to the refitted residual in five folds of held-out units of exchange.

    Raises
    ------
    TactileDataError
        scikit-learn is not installed.
    """
    need_packages("a diagnosis", "sklearn")
    from sklearn.ensemble import HistGradientBoostingRegressor
    from threadpoolctl import threadpool_limits

    residuals = projection.residuals
    columns = features(residuals)
    predicted = np.zeros_like(projection.score)
    fold = folds(residuals, seed)
    if columns.shape[1]:
        # trees this small are slower on several threads, and ten times slower beside other work
        with threadpool_limits(limits=1, user_api="openmp"):
            for number in np.unique(fold):
                train, test = fold != number, fold == number
                for component in range(predicted.shape[1]):
                    learner = HistGradientBoostingRegressor(
                        max_iter=TREES,
                        max_leaf_nodes=LEAVES,
                        min_samples_leaf=20,
                        early_stopping=False,
                        random_state=seed,
                    )
                    learner.fit(columns[train], projection.score[train, component])
                    predicted[test, component] = learner.predict(columns[test])
    # predictions that do harm are dropped, so that the explained share is never negative
    before = float((projection.score**2).sum())
    squares = residuals.by_unit(((projection.score - predicted) ** 2).sum(axis=1))
    if squares.sum() >= before:
        predicted = np.zeros_like(predicted)
        squares = residuals.by_unit((projection.score**2).sum(axis=1))
    explained = max(0.0, 1.0 - float(squares.sum()) / max(before, 1e-300))
    return BlackBox(predicted, squares, explained, _p(projection, predicted))


def _p(projection: ProjectedResiduals, predicted: Array) -> float:
    """Return the one-sided p-value of the products of residual and prediction, one for each unit of exchange.

    Two units of different folds predict one another, so that their products are correlated: the standard error of the
    sum is the square root of 2 times that of independent products.
    """
    agreement = projection.residuals.by_unit((projection.score * predicted).sum(axis=1))
    size = float(np.sqrt(2.0 * (agreement**2).sum()))
    return float(student.sf(float(agreement.sum()) / size, len(agreement) - 1)) if size > 0 else 1.0
