"""How well a fitted model tells what it has not seen: whole trajectories, and whole indenters, held out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array, Indices
from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.naming.linearise import bounded_change
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.touches.whitened import WhitenedTouches

FOLDS = 5


@dataclass(frozen=True)
class GroupedCosts:
    """Squares of what was left of groups that were held out, offsets and numerical errors marginalised.

    Parameters
    ----------
    by_trajectory : (t,)
        Five folds of trajectories.
    by_indenter : (i,)
        Each indenter in its turn; empty where there is one only.
    """

    by_trajectory: Array
    by_indenter: Array


def held_out(cases: WhitenedTouches, fit: JointFit, seed: int = 0) -> GroupedCosts:
    """Each group told by a fit to the others; that fit is a step from the whole one, in its linearisation.

    The effects' numbers and E, nu, mu move; what is of one trajectory or one indenter only is left to its prior.
    """
    count = len(cases.starts)
    dealt = folds_of(count, seed)
    by_trajectory = np.zeros(count)
    refits = LinearRefits.of(cases, fit)
    for fold in range(int(dealt.max()) + 1):
        for one, cost in refits.costs(dealt == fold, together=False).items():
            by_trajectory[one] = cost
    kinds = int(cases.indenter.max()) + 1
    by_indenter = np.array(
        [sum(refits.costs(cases.indenter == kind, together=True).values()) for kind in range(kinds)]
        if kinds > 1
        else []
    )
    return GroupedCosts(by_trajectory, by_indenter)


def folds_of(count: int, seed: int = 0) -> Indices:
    """Fold (t,) of each of so many trajectories."""
    return np.random.default_rng(seed).permutation(np.arange(count) % min(FOLDS, count))


@dataclass(frozen=True)
class LinearRefits:
    """What each trajectory tells: normal equations of its own, to be summed over those that are fitted."""

    cases: WhitenedTouches
    fit: JointFit
    gram: Array
    told: Array
    undone: Array

    @staticmethod
    def of(cases: WhitenedTouches, fit: JointFit) -> LinearRefits:
        """Of a fit to these trajectories."""
        undone = fit.residual + fit.own * fit.by_row
        metric = RandomEffects(fit.own, fit.shared[:, :, :0], fit.precision[:0], fit.starts)
        weighed = metric.without_own(fit.shared)
        gram = np.stack([
            np.einsum("nkp,nkq->pq", fit.shared[rows], weighed[rows], optimize=True) for rows in _rows(cases)
        ])  # fmt: skip
        told = np.add.reduceat(np.einsum("nkp,nk->np", weighed, undone), fit.starts, axis=0)
        return LinearRefits(cases, fit, gram, told, undone)

    def change_without(self, out: NDArray[np.bool_]) -> Array:
        """By how much the vector (q,) moves where some trajectories (t,) are not fitted, in the fit's linearisation."""
        fit = self.fit
        prior = fit.precision * (fit.model.vector - fit.centre)
        gram = self.gram[~out].sum(axis=0) + np.diag(fit.precision)
        low, high = (end - fit.model.vector for end in fit.model.bounds)
        return bounded_change(gram, self.told[~out].sum(axis=0) - prior, low, high)

    def costs(self, out: NDArray[np.bool_], together: bool) -> dict[int, float]:
        """Of each trajectory held out, or of all of them as one under the first one's number."""
        fit = self.fit
        left = self.undone - fit.shared @ self.change_without(out)
        first_error = len(fit.precision) - len(fit.model.errors)
        numbers = np.flatnonzero(out)
        groups = [numbers] if together else [np.array([number]) for number in numbers]
        costs = {}
        for group in groups:
            rows = np.isin(self.cases.trajectory, group)
            starts = np.concatenate([[0], np.cumsum(self.cases.touch_set.counts[group])[:-1]]).astype(np.int64)
            random = fit.shared[rows][:, :, first_error:] if together else fit.shared[rows][:, :, :0]
            if together:
                # the indenter's own factor was not fitted: it is at its prior's centre, with its spread
                kind = int(self.cases.indenter[group[0]])
                random = random[:, :, [kind]]
            metric = RandomEffects(fit.own[rows], random, np.ones(random.shape[2]), starts)
            costs[int(group[0])] = metric.cost(left[rows])
        return costs


def _rows(cases: WhitenedTouches) -> list[slice]:
    return [slice(start, start + count) for start, count in zip(cases.starts, cases.touch_set.counts, strict=True)]
