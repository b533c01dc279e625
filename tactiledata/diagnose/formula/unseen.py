"""What an open form does for trajectories that had no part in choosing or fitting it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.formula.candidates import Candidates
from tactiledata.diagnose.formula.select import choose
from tactiledata.diagnose.residuals.learners import folds
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.residuals import Residuals


@dataclass(frozen=True)
class UnseenFormula:
    """Residuals of trajectories, each fitted and explained by others.

    Parameters
    ----------
    before, after : (n, k)
        Whitened residuals with shared parameters refitted, without and with the terms that the others chose.
    squares_before, squares_after : (u,)
        Sums of squares of each unit of exchange, own parameters marginalised.
    counts : (u,)
        Values that each sum holds.
    """

    before: Array
    after: Array
    squares_before: Array
    squares_after: Array
    counts: Array


def held_out(residuals: Residuals, candidates: Candidates, seed: int = 0) -> UnseenFormula:
    """Choice, coefficients and refit by four fifths of the units, applied to the fifth that is left."""
    before, after = residuals.values.copy(), residuals.values.copy()
    fold = folds(residuals, seed)
    shared = list(residuals.shared)
    for number in np.unique(fold):
        train, test = fold != number, fold == number
        learning = residuals.part(train)
        accepted, _ = choose(learning, candidates.part(train), seed)
        fields = candidates.fields([one.number for one in accepted])
        known = {name: field[train] for name, field in fields.items()}
        plain = project(learning).refit
        full = project(learning.with_fields(known)).refit
        slopes = residuals.slopes[test][:, :, shared]
        before[test] -= slopes @ plain
        after[test] -= np.concatenate([slopes, *(field[test, :, None] for field in fields.values())], axis=2) @ full
    projection = project(residuals)
    squares = [residuals.by_unit((one * projection.weigh(one)).sum(axis=1)) for one in (before, after)]
    counts = residuals.by_unit(np.full(len(before), float(before.shape[1])))
    return UnseenFormula(before, after, squares[0], squares[1], counts)
