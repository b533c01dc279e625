"""Covariates and labels as columns of numbers, for learners that ask for no more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.learners import folds, need_learning_library
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import Residuals


def features(residuals: Residuals) -> Array:
    """Columns (n, f): covariates as they are, labels by number."""
    columns = [one.values for one in residuals.covariates.values()]
    columns += [np.unique(texts, return_inverse=True)[1].astype(np.float64) for texts in residuals.labels.values()]
    return np.column_stack(columns) if columns else np.zeros((len(residuals.values), 0))


LEVEL = 0.01
"""Small beside the 5 % of all locators, as it is asked beside them."""
WORTH = 0.02
"""Share of the squares of held-out groups that is worth a sentence."""
TREES = 60
LEAVES = 12


@dataclass(frozen=True)
class BlackBox:
    """The ceiling.

    Parameters
    ----------
    predicted : (n, k)
        Of trajectories by trees that were grown on others; 0 where they would do harm to all together.
    squares : (u,)
        Sums of squares of each unit of exchange that they leave, own parameters at their most likely values.
    explained : float
        Share of the squares that they explain, not below 0.
    p : float
        Of the agreement between residuals and what was predicted of them.
    """

    predicted: Array
    squares: Array
    explained: float
    p: float

    @property
    def is_certain(self) -> bool:
        """Whether there is structure that they foresee: enough to be said, and not by chance."""
        return self.explained >= WORTH and self.p <= LEVEL


def black_box(projection: ProjectedResiduals, seed: int = 0) -> BlackBox:
    """Boosted trees on the refitted residual, trajectories held out by fives."""
    need_learning_library()
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
    before = float((projection.score**2).sum())
    squares = residuals.by_unit(((projection.score - predicted) ** 2).sum(axis=1))
    if squares.sum() >= before:
        predicted = np.zeros_like(predicted)
        squares = residuals.by_unit((projection.score**2).sum(axis=1))
    explained = max(0.0, 1.0 - float(squares.sum()) / max(before, 1e-300))
    return BlackBox(predicted, squares, explained, _p(projection, predicted))


def _p(projection: ProjectedResiduals, predicted: Array) -> float:
    """Chance of so much agreement of residuals with their predictions.

    A pair of units of different folds predicts one another, so that agreements come in pairs: their sum scatters by the
    square root of 2 more than it would if they were independent.
    """
    agreement = projection.residuals.by_unit((projection.score * predicted).sum(axis=1))
    size = float(np.sqrt(2.0 * (agreement**2).sum()))
    return float(student.sf(float(agreement.sum()) / size, len(agreement) - 1)) if size > 0 else 1.0
