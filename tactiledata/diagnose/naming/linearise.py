"""Linearisation of a joint model about its present numbers, and the damped step that it promises."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array, Indices, Mask
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.parameters import JointModel
from tactiledata.diagnose.naming.signatures import material_fields, material_precision, own_field
from tactiledata.diagnose.touches.touch_case import Played
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.errors import UsageError
from tactiledata.nuisance.offsets import FARTHEST, PRIOR

DIFFERENCE = 0.2
"""Step of the finite differences over a coordinate, in units of its scale."""
FAINTEST = 1e-30
"""Information on a number, as a share of the largest one, below which it counts as so much: nothing overflows."""
FARTHEST_STEP = 3.0
"""Farthest that a coordinate moves in one round, in units of its scale: the linearisation holds no farther."""


@dataclass(frozen=True)
class Evaluation:
    """A model's prediction, its residual and its cost.

    Parameters
    ----------
    predicted : Played
        Simulated wrenches of all trajectories, without errors of the simulation.
    erred : (N, 6)
        The same with the model's errors of the simulation, N and N m.
    residual : (N, 6)
        Whitened: measured less predicted.
    cost : float
        Sum of squares of the residual and of all priors.
    """

    predicted: Played
    erred: Array
    residual: Array
    cost: float


@dataclass(frozen=True)
class Sensitivities:
    """Whitened derivatives of the predicted wrench.

    Parameters
    ----------
    shared : (N, 6, q)
        Over each entry of the model's vector.
    own : (N, 6)
        Over one standard deviation of the contact offset of the row's trajectory.
    """

    shared: Array
    own: Array


@dataclass(frozen=True)
class Linearised:
    """The least-squares problem of a joint fit: data, and which entries do not move.

    Errors of the simulation are shares of simulated wrenches. They are taken about the wrenches of each model, so that
    they move with material and effects.

    Parameters
    ----------
    whitened : WhitenedTouches
        Measured trajectories.
    held : frozenset of int
        Entries of the model's vector that do not move.
    """

    whitened: WhitenedTouches
    held: frozenset[int]

    def precision(self, model: JointModel) -> Array:
        """Return the inverse variance (q,) of the prior of each entry; 0 where there is none."""
        of_effects = [1.0 if coordinate.is_strength else 0.0 for coordinate in model.coordinates]
        return np.concatenate([material_precision(), of_effects, np.ones(len(model.errors))])

    def centre(self, model: JointModel) -> Array:
        """Return the mean (q,) of the prior of each entry: the middle of the bounds for nu, 0 for the others."""
        low, high = model.bounds
        centre = np.zeros(len(low))
        centre[1] = (low[1] + high[1]) / 2.0
        return centre

    def evaluate(self, model: JointModel) -> Evaluation:
        """Return prediction, residual and cost of a model.

        Raises
        ------
        UsageError
            Gel and springs find no balance.
        """
        predicted = self.whitened.touch_set.played(model.material, model.settings, model.offsets)
        erred = self.whitened.erred(predicted, model.errors)
        residual = self.whitened.residual(erred)
        off = model.vector - self.centre(model)
        priors = self.precision(model) @ off**2 + ((model.offsets / PRIOR) ** 2).sum()
        return Evaluation(predicted, erred, residual, float((residual**2).sum() + priors))

    def costs(self, model: JointModel, residual: Array) -> Array:
        """Return the part (t,) of the cost that is each trajectory's own: its residual and the prior of its offset."""
        squares: Array = np.add.reduceat((residual**2).sum(axis=1), self.whitened.starts)
        return squares + (model.offsets / PRIOR) ** 2

    def evaluate_or_none(self, model: JointModel) -> Evaluation | None:
        """Return prediction, residual and cost of a model; ``None`` where gel and springs find no balance."""
        try:
            return self.evaluate(model)
        except UsageError:
            return None

    def slopes(self, model: JointModel, state: Evaluation) -> Sensitivities:
        """Return finite-difference derivatives about a model whose evaluation is known."""
        settings, offsets, errors = model.settings, model.offsets, model.errors
        gel = material_fields(self.whitened, model.material, settings, offsets, state.predicted, errors)
        own = own_field(self.whitened, model.material, settings, offsets, state.predicted, errors)
        vector, high = model.vector, model.bounds[1]
        fields = []
        for entry in range(3, 3 + len(model.coordinates)):
            there = vector.copy()
            # a difference backwards where the upper bound is near
            step = DIFFERENCE if vector[entry] + DIFFERENCE <= high[entry] else -DIFFERENCE
            there[entry] += step
            moved = model.at(there, offsets)
            setting = moved.settings[model.coordinates[entry - 3].setting_index]
            changed = self.whitened.touch_set.simulate_where(
                setting, state.predicted, moved.material, moved.settings, offsets
            )
            erred = self.whitened.erred(changed, errors)
            fields.append(self.whitened.whiten(erred - state.erred)[:, :, None] / step)
        if len(errors):
            wrenches = self.whitened.error_frames.wrenches(state.predicted.wrench, state.predicted.friction)
            fields.append(self.whitened.whiten(wrenches))
        return Sensitivities(np.concatenate([gel, *fields], axis=2), own)

    def step(
        self, model: JointModel, state: Evaluation, slopes: Sensitivities, damping: float
    ) -> tuple[JointModel, float]:
        """Return the model after one damped step, and by how much the linearisation says that the cost falls.

        The entries of the vector move first, the offsets eliminated from the equations; the offsets follow.

        Parameters
        ----------
        model : JointModel
            Present numbers.
        state, slopes : Evaluation, Sensitivities
            Evaluation and derivatives of this model.
        damping : float
            Share of its diagonal that is added to the matrix of the normal equations (Levenberg and Marquardt).
        """
        vector = model.vector
        precision = self.precision(model)
        # normal equations of the shared entries, each trajectory's offset eliminated
        about = RandomEffects(slopes.own, slopes.shared[:, :, :0], precision[:0], self.whitened.starts)
        own_now = model.offsets / PRIOR
        starts = self.whitened.starts
        squares = (1.0 + damping) * (1.0 + np.add.reduceat(np.einsum("nk,nk->n", slopes.own, slopes.own), starts))
        by_row = self.whitened.trajectory
        pulled = offset_steps(slopes.own, state.residual, starts, squares, own_now)
        pull = state.residual - slopes.own * pulled[by_row, None]
        gradient = np.einsum("nkq,nk->q", slopes.shared, pull) - precision * (vector - self.centre(model))
        gram = about.products(slopes.shared, slopes.shared) + np.diag(precision)
        # the step within bounds, effects within the reach of the linearisation
        free = np.array([entry not in self.held for entry in range(len(vector))])
        damped = gram + damping * np.diag(np.diag(gram))
        moved = vector + bounded_change(damped, gradient, *step_bounds(model), free)
        # the offsets follow, and the cost that is reached to first order
        left = state.residual - slopes.shared @ (moved - vector)
        own = own_now + offset_steps(slopes.own, left, starts, squares, own_now)
        own = np.clip(own, -FARTHEST / PRIOR, FARTHEST / PRIOR)
        left = left - slopes.own * (own - own_now)[by_row, None]
        reached = (left**2).sum() + precision @ (moved - self.centre(model)) ** 2 + (own**2).sum()
        return model.at(moved, own * PRIOR), state.cost - float(reached)


def step_bounds(model: JointModel) -> tuple[Array, Array]:
    """Return the lowest and the highest step (q,) of a model's vector for which its linearisation holds.

    Numbers stay within their bounds, and those of effects within ``FARTHEST_STEP``: a time constant of an effect that
    is absent would go anywhere.
    """
    low, high = (end - model.vector for end in model.bounds)
    of_effects = slice(3, 3 + len(model.coordinates))
    low[of_effects] = np.maximum(low[of_effects], -FARTHEST_STEP)
    high[of_effects] = np.minimum(high[of_effects], FARTHEST_STEP)
    return low, high


def offset_steps(own: Array, residual: Array, starts: Indices, squares: Array, now: Array) -> Array:
    """Return by how much each trajectory's contact offset (t,) should move, in standard deviations of its prior.

    This is the minimum over the offset of each trajectory alone, its prior included, to first order. An offset above 0
    is a contact that is deeper than recorded.

    Parameters
    ----------
    own : (N, 6)
        Whitened change over one standard deviation of the offset.
    residual : (N, 6)
        Whitened: measured less predicted.
    starts : (t,)
        First row of each trajectory.
    squares : (t,)
        One (of the prior) plus the sum of squares of ``own``.
    now : (t,)
        Present offsets, in standard deviations.
    """
    return (np.add.reduceat(np.einsum("nk,nk->n", own, residual), starts) - now) / squares


def inverse_of(gram: Array) -> Array:
    """Return the pseudo-inverse of a symmetric matrix (q, q), its diagonal scaled to 1 for the cut-off.

    Directions without information, below 1e-12 of the largest, are 0 in it.
    """
    diagonal = np.diag(gram)
    scale = np.sqrt(np.maximum(diagonal, max(1e-300, FAINTEST * float(diagonal.max(initial=0.0)))))
    inverse: Array = np.linalg.pinv(gram / np.outer(scale, scale), rcond=1e-12, hermitian=True)
    return inverse / np.outer(scale, scale)


def bounded_change(gram: Array, gradient: Array, low: Array, high: Array, free: Mask | None = None) -> Array:
    """Return the step (q,) that solves ``gram @ step = gradient`` within bounds.

    An entry that would leave its bounds stays at the bound for good; the others are solved for again.

    Parameters
    ----------
    gram : (q, q)
        Matrix of the normal equations, symmetric.
    gradient : (q,)
        Right-hand side: half the negative gradient of the cost.
    low, high : (q,)
        Bounds of the step, not of the entries.
    free : (q,) bool, optional
        Entries that may move; all where ``None``.
    """
    change = np.zeros(len(gradient))
    moves = np.ones(len(gradient), dtype=bool) if free is None else free.copy()
    while moves.any():
        inner = gram[np.ix_(moves, moves)]
        change[moves] = inverse_of(inner) @ (gradient[moves] - gram[np.ix_(moves, ~moves)] @ change[~moves])
        within = np.clip(change, low, high)
        left = moves & (within != change)
        change = within
        if not left.any():
            break
        moves &= ~left
    return change
