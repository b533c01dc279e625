"""E, nu, mu, the strengths of effects and all nuisance at once, by damped Gauss-Newton that is linearised anew."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.effect_signatures import material_fields, material_precision, own_field
from tactiledata.diagnose.joint_model import JointModel
from tactiledata.diagnose.random_effects import RandomEffects
from tactiledata.diagnose.whitened_cases import WhitenedCases
from tactiledata.errors import UsageError
from tactiledata.nuisance.offsets import FARTHEST, PRIOR

Array = NDArray[np.float64]

ROUNDS = 8
STILL = 0.05
"""Fall of the cost that ends a fit; twice the log-likelihood."""
DIFFERENCE = 0.2
"""Of a coordinate's scale, of the differences over it."""
MOST_DAMPING = 1e2
FARTHEST_STEP = 3.0
"""Scales, in one round."""


@dataclass(frozen=True)
class JointFit:
    """The best of a model, and how the data change about it; q numbers are shared by all trajectories.

    Parameters
    ----------
    model : JointModel
    cost : float
        Squares of the whitened residual and of all priors.
    residual : (N, 6), whitened
    shared : (N, 6, q)
        Change over the entries of the model's vector.
    precision, centre : (q,)
        Of their priors.
    own : (N, 6)
        Change over one standard deviation of the trajectory's offset.
    effect_change : (N, 6)
        Whitened wrench with the effects less that without, all else as fitted.
    """

    model: JointModel
    cost: float
    residual: Array
    shared: Array
    precision: Array
    centre: Array
    own: Array
    effect_change: Array
    starts: NDArray[np.int64]

    @property
    def names(self) -> tuple[str, ...]:
        """Of effects in it."""
        return tuple(dict.fromkeys(setting.effect for setting in self.model.settings))

    @property
    def of_effects(self) -> Array:
        """Change (N, 6, c) over the effects' numbers."""
        return self.shared[:, :, 3 : 3 + len(self.model.coordinates)]

    @property
    def by_row(self) -> Array:
        """Offset (N, 1) of each row's trajectory, in standard deviations."""
        counts = np.diff(self.starts, append=len(self.own))
        return np.repeat(self.model.offsets / PRIOR, counts)[:, None]

    @property
    def by_trajectory(self) -> Array:
        """Squares (t,) of each trajectory's residual and offset: of the cost, what is not of shared numbers."""
        squares: Array = np.add.reduceat((self.residual**2).sum(axis=1), self.starts)
        return squares + (self.model.offsets / PRIOR) ** 2

    @property
    def metric(self) -> RandomEffects:
        """What another refit of the same model could imitate, linearised here: what stands at a bound stays there."""
        vector, (low, high) = self.model.vector, self.model.bounds
        edge = 1e-6 * np.maximum(1.0, np.abs(vector))
        inside = (vector > low + edge) & (vector < high - edge)
        return RandomEffects(self.own, self.shared[:, :, inside], self.precision[inside], self.starts)

    @property
    def undone(self) -> Array:
        """The residual (N, 6) with all that has a prior back at its centre, to first order: for scores in `metric`."""
        vector, (low, high) = self.model.vector, self.model.bounds
        edge = 1e-6 * np.maximum(1.0, np.abs(vector))
        goes_back = (self.precision > 0) & (vector > low + edge) & (vector < high - edge)
        back = np.where(goes_back, vector - self.centre, 0.0)
        return self.residual + self.own * self.by_row + self.shared @ back

    @property
    def occam(self) -> float:
        """What is paid for the effects' numbers: the logarithm of how much narrower data make their strengths than the
        priors, beside all else, and that of how many shapes are tried.

        Source: Laplace's approximation of a Bayes factor, as in MacKay, Neural Computation 4 (1992).
        """
        told = self.model.coordinates
        is_of_effects = np.zeros(self.shared.shape[2], dtype=bool)
        is_of_effects[3 : 3 + len(told)] = True
        beside = RandomEffects(self.own, self.shared[:, :, ~is_of_effects], self.precision[~is_of_effects], self.starts)
        strengths = self.of_effects[:, :, [one.is_strength for one in told]]
        narrowed = np.eye(strengths.shape[2]) + beside.products(strengths, strengths)
        shapes = sum(np.log(len(one.parameter.grid)) for one in told if not one.is_strength)
        return float(0.5 * np.linalg.slogdet(narrowed)[1] + shapes)

    @property
    def covariance(self) -> Array:
        """Of the vector (q, q), as noise and priors have it."""
        about = RandomEffects(self.own, self.shared[:, :, :0], self.precision[:0], self.starts)
        return inverse_of(about.products(self.shared, self.shared) + np.diag(self.precision))


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


def joint_fit(
    cases: WhitenedCases, numerical: Array, start: JointModel, held: Iterable[int] = (), rounds: int = ROUNDS
) -> JointFit:
    """The model whose residual and priors are least, from a start.

    Parameters
    ----------
    numerical : (N, 6, e)
        Whitened numerical errors, the same for all models that are compared.
    held : places of the vector that stay
    """
    work = _Work(cases, numerical, frozenset(held))
    model, damping = start, 1e-3
    state = work.weighed(model)
    for _ in range(rounds):
        slopes = work.slopes(model, state)
        fell = 0.0
        while damping < MOST_DAMPING:
            tried, promised = work.step(model, state, slopes, damping)
            if promised < STILL:
                break
            after = work.weighed_or_none(tried)
            if after is not None and after.cost <= state.cost:
                fell, model, state, damping = state.cost - after.cost, tried, after, max(damping / 10.0, 1e-6)
                break
            damping *= 10.0
        if fell < STILL:
            break
    slopes = work.slopes(model, state)
    plain = cases.cases.play(model.material, [], model.offsets)
    changed = cases.white(state.predicted - plain)
    return JointFit(
        model, state.cost, state.residual, slopes.shared, work.precision(model), work.centre(model), slopes.own,
        changed, cases.starts,
    )  # fmt: skip


@dataclass(frozen=True)
class _State:
    predicted: Array
    residual: Array
    cost: float


@dataclass(frozen=True)
class _Slopes:
    shared: Array
    own: Array


@dataclass(frozen=True)
class _Work:
    cases: WhitenedCases
    numerical: Array
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

    def weighed(self, model: JointModel) -> _State:
        """Prediction, residual and cost."""
        predicted = self.cases.cases.play(model.material, model.settings, model.offsets)
        residual = self.cases.residual(predicted) - self.numerical @ model.errors
        off = model.vector - self.centre(model)
        priors = self.precision(model) @ off**2 + ((model.offsets / PRIOR) ** 2).sum()
        return _State(predicted, residual, float((residual**2).sum() + priors))

    def weighed_or_none(self, model: JointModel) -> _State | None:
        """The same; nothing where gel and springs find no balance."""
        try:
            return self.weighed(model)
        except UsageError:
            return None

    def slopes(self, model: JointModel, state: _State) -> _Slopes:
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
            changed = self.cases.cases.play_where(setting, state.predicted, moved.material, moved.settings, offsets)
            fields.append(self.cases.white(changed - state.predicted) / step)
        return _Slopes(np.concatenate([gel, *(one[:, :, None] for one in fields), self.numerical], axis=2), own)

    def step(self, model: JointModel, state: _State, slopes: _Slopes, damping: float) -> tuple[JointModel, float]:
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
