"""How well a fitted model predicts data it was not fitted to: whole trajectories and whole indenters, held out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array, Indices, Mask
from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.naming.linearise import Linearised, bounded_change, step_bounds
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.parameters import JointModel
from tactiledata.diagnose.touches.whitened import WhitenedTouches

FOLDS = 5
"""Largest number of folds into which trajectories are dealt."""
HALVINGS = 6
"""Largest number of times that a step is halved because the fitted trajectories, simulated anew, get worse by it."""


@dataclass(frozen=True)
class GroupedCosts:
    """Sums of squares of the whitened residual of held-out trajectories, their contact offsets marginalised.

    Parameters
    ----------
    by_trajectory : (t,)
        Of each trajectory, held out with the others of its fold.
    by_indenter : (i,)
        Of all trajectories of each indenter, held out together, the simulation's errors of that indenter marginalised;
        empty where there is one indenter only.
    """

    by_trajectory: Array
    by_indenter: Array


def held_out(whitened: WhitenedTouches, fit: JointFit, seed: int = 0) -> GroupedCosts:
    """Return the sums of squares that held-out trajectories and indenters have under a fit to the others.

    The fit to the others is not iterated: it is one step from the fit to all (`HeldOutRefits.without`). E, nu, mu, the
    effects' numbers and the errors of the simulation move, and the held-out trajectories are simulated anew. The
    contact offset of a held-out trajectory, and the simulation's errors of a held-out indenter, are marginalised under
    their priors.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories.
    fit : JointFit
        Fit to all of them.
    seed : int
        Random seed with which trajectories are dealt to at most five folds.

    Returns
    -------
    GroupedCosts
        Whitened squares of each trajectory (t,) and of each indenter (i,); the latter are empty for one indenter.
    """
    count = len(whitened.starts)
    dealt = folds_of(count, seed)
    by_trajectory = np.zeros(count)
    refits = HeldOutRefits.of(whitened, fit)
    for fold in range(int(dealt.max()) + 1):
        for number, cost in refits.costs(dealt == fold, together=False).items():
            by_trajectory[number] = cost
    indenters = int(whitened.indenter.max()) + 1
    by_indenter = np.array(
        [sum(refits.costs(whitened.indenter == indenter, together=True).values()) for indenter in range(indenters)]
        if indenters > 1
        else []
    )
    return GroupedCosts(by_trajectory, by_indenter)


def folds_of(count: int, seed: int = 0) -> Indices:
    """Return the fold (t,) of each of ``count`` trajectories: equal parts in random order."""
    return np.random.default_rng(seed).permutation(np.arange(count) % min(FOLDS, count))


@dataclass(frozen=True)
class HeldOutRefits:
    """Refits to some of the trajectories, each by one step from the fit to all of them.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories.
    fit : JointFit
        Fit to all of them; q numbers are shared.
    grams : (t, q, q)
        Matrix of the normal equations of each trajectory, its contact offset marginalised.
    gradients : (t, q)
        Right-hand side of each trajectory.
    """

    whitened: WhitenedTouches
    fit: JointFit
    grams: Array
    gradients: Array

    @staticmethod
    def of(whitened: WhitenedTouches, fit: JointFit) -> HeldOutRefits:
        """Return the normal equations about a fit to these trajectories."""
        metric = RandomEffects(fit.own, fit.shared[:, :, :0], fit.precision[:0], fit.starts)
        weighed = metric.without_own(fit.shared)
        grams = np.stack([
            np.einsum("nkp,nkq->pq", fit.shared[rows], weighed[rows], optimize=True) for rows in _rows(whitened)
        ])  # fmt: skip
        without_offsets = fit.residual + fit.own * fit.by_row
        gradients = np.add.reduceat(np.einsum("nkp,nk->np", weighed, without_offsets), fit.starts, axis=0)
        return HeldOutRefits(whitened, fit, grams, gradients)

    def without(self, out: Mask) -> tuple[JointModel, Array]:
        """Return the refit without the trajectories marked in ``out`` (t,), and the residual (N, 6) of all of them.

        The step is that of the linearisation about the fit to all. Where the trajectories that are fitted, simulated
        anew, get worse by it, the linearisation does not hold so far: the step is halved, at most ``HALVINGS`` times.
        If they still get worse, the numbers stay as they are. Contact offsets stay as fitted.
        """
        fit, work = self.fit, Linearised(self.whitened, frozenset())
        change = self._change_without(out)
        before = self._cost_of_fitted(out, fit.model, fit.residual)
        for halving in range(HALVINGS + 1):
            moved = fit.model.at(fit.model.vector + 0.5**halving * change, fit.model.offsets)
            after = work.evaluate_or_none(moved)
            if after is not None and self._cost_of_fitted(out, moved, after.residual) <= before:
                return moved, after.residual
        return fit.model, fit.residual

    def _change_without(self, out: Mask) -> Array:
        """Return by how much the vector (q,) moves, to first order, if the trajectories in ``out`` are not fitted."""
        fit = self.fit
        prior = fit.precision * (fit.model.vector - fit.centre)
        gram = self.grams[~out].sum(axis=0) + np.diag(fit.precision)
        return bounded_change(gram, self.gradients[~out].sum(axis=0) - prior, *step_bounds(fit.model))

    def _cost_of_fitted(self, out: Mask, model: JointModel, residual: Array) -> float:
        """Return the cost of a model with this residual (N, 6), without trajectories in ``out``, without offsets."""
        fit = self.fit
        pulled = residual + fit.own * fit.by_row
        own = np.add.reduceat((fit.own * pulled).sum(axis=1), fit.starts)
        size = 1.0 + np.add.reduceat((fit.own**2).sum(axis=1), fit.starts)
        squares = np.add.reduceat((pulled**2).sum(axis=1), fit.starts) - own**2 / size
        return float(squares[~out].sum() + fit.precision @ (model.vector - fit.centre) ** 2)

    def costs(self, out: Mask, together: bool) -> dict[int, float]:
        """Return the sums of squares of held-out trajectories, by the number of the trajectory.

        Parameters
        ----------
        out : (t,) bool
            Trajectories that are held out.
        together : bool
            Whether they are all trajectories of one indenter. These are one group with one sum, which is filed under
            the number of its first trajectory.
        """
        fit = self.fit
        left = self.without(out)[1] + fit.own * fit.by_row
        first_error = len(fit.precision) - len(fit.model.errors)
        numbers = np.flatnonzero(out)
        groups = [numbers] if together else [np.array([number]) for number in numbers]
        costs = {}
        for group in groups:
            rows = np.isin(self.whitened.trajectory, group)
            starts = np.concatenate([[0], np.cumsum(self.whitened.touch_set.counts[group])[:-1]]).astype(np.int64)
            random = fit.shared[rows][:, :, first_error:] if together else fit.shared[rows][:, :, :0]
            if together:
                # the indenter's own errors were not fitted: they are at their prior's centre, with its spread
                name = self.whitened.indenter_names[int(self.whitened.indenter[group[0]])]
                random = random[:, :, [error.indenter == name for error in self.whitened.simulation_errors]]
            metric = RandomEffects(fit.own[rows], random, np.ones(random.shape[2]), starts)
            costs[int(group[0])] = metric.cost(left[rows])
        return costs


def _rows(whitened: WhitenedTouches) -> list[slice]:
    """Rows of each trajectory."""
    return [
        slice(start, start + count) for start, count in zip(whitened.starts, whitened.touch_set.counts, strict=True)
    ]


@dataclass(frozen=True)
class HeldOutTask:
    """A fit whose held-out squares a worker can compute.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories.
    fit : JointFit
        Fit to them.
    seed : int
        Random seed of the folds.
    """

    whitened: WhitenedTouches
    fit: JointFit
    seed: int

    def __str__(self) -> str:
        return f"held-out trajectories of {' with '.join(self.fit.names)}"

    def costs(self) -> GroupedCosts:
        """Return the squares; workers execute this function."""
        return held_out(self.whitened, self.fit, self.seed)
