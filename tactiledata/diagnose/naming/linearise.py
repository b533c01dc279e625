"""A joint model's linearisation about a guess, and the step that it promises."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.parameters import JointModel
from tactiledata.diagnose.naming.signatures import material_fields, material_precision, own_field
from tactiledata.diagnose.touches.touch_case import Played
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.errors import UsageError
from tactiledata.nuisance.offsets import FARTHEST, PRIOR

DIFFERENCE = 0.2
"""Of a coordinate's scale, of the differences over it."""
FARTHEST_STEP = 3.0
"""Scales, in one round."""


@dataclass(frozen=True)
class Evaluation:
    """What a model predicts, what is left of it (N, 6), whitened, and its cost with all priors."""

    predicted: Played
    residual: Array
    cost: float


@dataclass(frozen=True)
class Sensitivities:
    """Whitened change (N, 6, q) over the entries of a model's vector, (N, 6) over a deviation of each offset."""

    shared: Array
    own: Array


@dataclass(frozen=True)
class Linearised:
    """Trajectories and the errors of their simulation; ``held``: places of a model's vector that stay.

    Parameters
    ----------
    cases : WhitenedTouches
    simulation_error_fields : (N, 6, e)
        Whitened numerical errors.
    held : frozenset of int
    """

    cases: WhitenedTouches
    simulation_error_fields: Array
    held: frozenset[int]

    def precision(self, model: JointModel) -> Array:
        """Of the priors (q,)."""
        of_effects = [1.0 if one.is_strength else 0.0 for one in model.coordinates]
        return np.concatenate([material_precision(), of_effects, np.ones(len(model.errors))])

    def centre(self, model: JointModel) -> Array:
        """Of the priors (q,)."""
        low, high = model.bounds
        centre = np.zeros(len(low))
        centre[1] = (low[1] + high[1]) / 2.0
        return centre

    def weighed(self, model: JointModel) -> Evaluation:
        """Prediction, residual and cost."""
        predicted = self.cases.touch_set.played(model.material, model.settings, model.offsets)
        residual = self.cases.residual(predicted.wrench) - self.simulation_error_fields @ model.errors
        off = model.vector - self.centre(model)
        priors = self.precision(model) @ off**2 + ((model.offsets / PRIOR) ** 2).sum()
        return Evaluation(predicted, residual, float((residual**2).sum() + priors))

    def weighed_or_none(self, model: JointModel) -> Evaluation | None:
        """The same; nothing where gel and springs find no balance."""
        try:
            return self.weighed(model)
        except UsageError:
            return None

    def slopes(self, model: JointModel, state: Evaluation) -> Sensitivities:
        """Differences about a model."""
        settings, offsets = model.settings, model.offsets
        gel = material_fields(self.cases, model.material, settings, offsets, state.predicted)
        own = own_field(self.cases, model.material, settings, offsets, state.predicted)
        vector, high = model.vector, model.bounds[1]
        fields = []
        for place in range(3, 3 + len(model.coordinates)):
            there = vector.copy()
            step = DIFFERENCE if vector[place] + DIFFERENCE <= high[place] else -DIFFERENCE
            there[place] += step
            moved = model.at(there, offsets)
            setting = moved.settings[model.coordinates[place - 3].place]
            changed = self.cases.touch_set.play_where(setting, state.predicted, moved.material, moved.settings, offsets)
            fields.append(self.cases.whiten(changed - state.predicted.wrench) / step)
        return Sensitivities(
            np.concatenate([gel, *(one[:, :, None] for one in fields), self.simulation_error_fields], axis=2), own
        )

    def step(
        self, model: JointModel, state: Evaluation, slopes: Sensitivities, damping: float
    ) -> tuple[JointModel, float]:
        """One damped step of the shared numbers, the offsets following, and by how much it should lessen the cost."""
        vector, (low, high) = model.vector, model.bounds
        precision = self.precision(model)
        about = RandomEffects(slopes.own, slopes.shared[:, :, :0], precision[:0], self.cases.starts)
        own_now = model.offsets / PRIOR
        starts = self.cases.starts
        squares = 1.0 + np.add.reduceat(np.einsum("nk,nk->n", slopes.own, slopes.own), starts)
        by_row = self.cases.trajectory
        pulled = offset_steps(slopes.own, state.residual, starts, squares, own_now)
        pull = state.residual - slopes.own * pulled[by_row, None]
        gradient = np.einsum("nkq,nk->q", slopes.shared, pull) - precision * (vector - self.centre(model))
        gram = about.products(slopes.shared, slopes.shared) + np.diag(precision)
        free = np.array([place not in self.held for place in range(len(vector))])
        of_effects = slice(3, 3 + len(model.coordinates))
        nearest, farthest = low.copy(), high.copy()
        nearest[of_effects] = np.maximum(low[of_effects], vector[of_effects] - FARTHEST_STEP)
        farthest[of_effects] = np.minimum(high[of_effects], vector[of_effects] + FARTHEST_STEP)
        damped = gram + damping * np.diag(np.diag(gram))
        moved = vector + bounded_change(damped, gradient, nearest - vector, farthest - vector, free)
        left = state.residual - slopes.shared @ (moved - vector)
        own = own_now + offset_steps(slopes.own, left, starts, squares, own_now)
        own = np.clip(own, -FARTHEST / PRIOR, FARTHEST / PRIOR)
        left = left - slopes.own * (own - own_now)[by_row, None]
        reached = (left**2).sum() + precision @ (moved - self.centre(model)) ** 2 + (own**2).sum()
        return model.at(moved, own * PRIOR), state.cost - float(reached)


def offset_steps(own: Array, residual: Array, starts: NDArray[np.int64], squares: Array, now: Array) -> Array:
    """By how much each trajectory's offset (t,) should move, in its standard deviations.

    Parameters
    ----------
    own, residual : (N, 6)
    squares : (t,)
        One more than the sum of those of ``own``.
    now : (t,)
        Where the offsets stand.
    """
    return (np.add.reduceat(np.einsum("nk,nk->n", own, residual), starts) - now) / squares


def inverse_of(gram: Array) -> Array:
    """Of a symmetric matrix, its scales evened out, directions without information left out."""
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    inverse: Array = np.linalg.pinv(gram / np.outer(scale, scale), rcond=1e-12, hermitian=True)
    return inverse / np.outer(scale, scale)


def bounded_change(gram: Array, told: Array, low: Array, high: Array, free: NDArray[np.bool_] | None = None) -> Array:
    """The step (q,) that solves ``gram step = told``; what would leave its bounds stays there, the others follow.

    Parameters
    ----------
    low, high : (q,)
        Of the step.
    free : (q,) bool, optional
        What may move at all.
    """
    change = np.zeros(len(told))
    moves = np.ones(len(told), dtype=bool) if free is None else free.copy()
    while moves.any():
        inner = gram[np.ix_(moves, moves)]
        change[moves] = inverse_of(inner) @ (told[moves] - gram[np.ix_(moves, ~moves)] @ change[~moves])
        within = np.clip(change, low, high)
        left = moves & (within != change)
        change = within
        if not left.any():
            break
        moves &= ~left
    return change
