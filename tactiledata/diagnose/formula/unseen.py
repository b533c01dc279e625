"""Residuals of trajectories with and without an open form that was chosen and fitted by others."""

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
    """Residuals of trajectories; shared parameters and formula come from other trajectories.

    Parameters
    ----------
    before, after : (n, k)
        Whitened residuals with shared parameters refitted, without and with the terms that other trajectories chose.
    squares_before, squares_after : (u,)
        Sums of squares of each unit of exchange, own parameters marginalised.
    counts : (u,)
        Number of values in each sum.
    """

    before: Array
    after: Array
    squares_before: Array
    squares_after: Array
    counts: Array


def held_out(residuals: Residuals, candidates: Candidates, seed: int = 0) -> UnseenFormula:
    """Return the residuals of each fifth of the units with the formula of the other four fifths.

    Terms, coefficients and shared parameters are all fitted without the fifth to which they are applied.

    Parameters
    ----------
    residuals : Residuals
    candidates : Candidates
        From which each choice is made.
    seed : int
        Draws the fifths, and what `tactiledata.diagnose.formula.select.choose` draws.
    """
    before, after = residuals.values.copy(), residuals.values.copy()
    fold = folds(residuals, seed)
    shared = list(residuals.shared)
    for number in np.unique(fold):
        train, test = fold != number, fold == number
        learning = residuals.part(train)
        accepted, _ = choose(learning, candidates.part(train), seed)
        fields = candidates.fields([term.number for term in accepted])
        known = {name: field[train] for name, field in fields.items()}
        # refits without and with the terms
        plain = project(learning).refit
        full = project(learning.with_fields(known)).refit
        slopes = residuals.slopes[test][:, :, shared]
        before[test] -= slopes @ plain
        after[test] -= np.concatenate([slopes, *(field[test, :, None] for field in fields.values())], axis=2) @ full
    projection = project(residuals)
    squares = [residuals.by_unit((left * projection.weigh(left)).sum(axis=1)) for left in (before, after)]
    counts = residuals.by_unit(np.full(len(before), float(before.shape[1])))
    return UnseenFormula(before, after, squares[0], squares[1], counts)
