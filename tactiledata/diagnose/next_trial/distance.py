"""How far two explanations are apart in what was recorded and in a trial, after one has been refitted to the other."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.joint_fit import JointFit, joint_fit
from tactiledata.diagnose.naming.linearise import bounded_change
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.parameters import JointModel
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import NumericalErrors, WhitenedTouches

NEAR = np.array([0.03, 0.005, 0.05])
"""Of ln E, nu and mu: so near to those of the truth a refit begins where the recorded data leave them open, as slopes
far away say nothing (what never slides does not feel friction)."""
ROUNDS, HALVINGS = 4, 3
AS_PROMISED = 0.1
"""Share, and units of noise squared, to which a step keeps what its slopes promise."""


def error_probability(square: float) -> float:
    """Chance to take one of two for the other, where they are apart by the root of ``square`` in noise."""
    return 0.5 * math.erfc(math.sqrt(max(square, 0.0)) / 2.0 / math.sqrt(2.0))


@dataclass(frozen=True)
class Recorded:
    """What the recorded data say when ``truth`` holds and ``other`` is refitted to it: a parabola of its numbers.

    Parameters
    ----------
    truth, other : JointFit
        In the same data.
    """

    truth: JointFit
    other: JointFit

    @cached_property
    def _about(self) -> RandomEffects:
        fit = self.other
        return RandomEffects(fit.own, fit.shared[:, :, :0], fit.precision[:0], fit.starts)

    @cached_property
    def _apart(self) -> Array:
        return self.other.residual - self.truth.residual

    @cached_property
    def information(self) -> Array:
        """Of the other's numbers (q, q), priors included."""
        shared = self.other.shared
        return self._about.products(shared, shared) + np.diag(self.other.precision)

    @cached_property
    def gradient(self) -> Array:
        """Towards the truth (q,)."""
        return self._about.products(self.other.shared, self._apart[:, :, None])[:, 0]

    @cached_property
    def square(self) -> float:
        """How far apart they are as fitted, in noise, squared; each trajectory's offset refitted."""
        return self._about.cost(self._apart)

    @cached_property
    def least(self) -> float:
        """The same with all numbers refitted."""
        vector, (low, high) = self.other.model.vector, self.other.model.bounds
        change = bounded_change(self.information, self.gradient, low - vector, high - vector)
        return max(self.square - 2.0 * float(change @ self.gradient) + float(change @ self.information @ change), 0.0)


@dataclass(frozen=True)
class TrialRows:
    """A trial's frames, whitened.

    Parameters
    ----------
    white : WhitenedTouches
    numerical : (n, 6, e)
        Numerical errors of the trial: one an indenter, by name, then those of all.
    columns : (e,) int
        Their places among those of the recorded data, and of indenters that were not recorded after these.
    errors, recorded : int
        How many numerical errors there are in all, and in the recorded data.
    """

    white: WhitenedTouches
    numerical: Array
    columns: NDArray[np.int64]
    errors: int
    recorded: int

    @staticmethod
    def of(trial: TouchSet, recorded: WhitenedTouches) -> TrialRows:
        """Of a trial beside what was recorded, with the same numerical errors."""
        before = sorted(set(recorded.touch_set.indenters))
        now = sorted(set(trial.indenters))
        new = [name for name in now if name not in before]
        errors: NumericalErrors = recorded.errors
        white = WhitenedTouches.of(trial, errors)
        numerical = white.simulation_error_fields(trial.touches[0].touch.material)
        common = numerical.shape[2] - len(now)
        known = len(before) + common
        places = [before.index(name) if name in before else known + new.index(name) for name in now]
        columns = np.array([*places, *range(len(before), known)])
        return TrialRows(white, numerical, columns, known + len(new), known)

    def model(self, fit: JointFit, vector: Array) -> JointModel:
        """The model of a fit, in the trial, at a vector of the fit's numbers and of further numerical errors."""
        numbers = 3 + len(fit.model.coordinates)
        offsets = np.zeros(len(self.white.starts))
        there = replace(fit.model, offsets=offsets, errors=np.zeros(len(self.columns)))
        return there.at(np.concatenate([vector[:numbers], vector[numbers:][self.columns]]), offsets)

    def residual(self, model: JointModel) -> Array:
        """What a model leaves (n, 6) of the wrenches by which the trial is weighed."""
        predicted = self.white.touch_set.play(model.material, model.settings, model.offsets)
        return self.white.residual(predicted) - self.numerical @ model.errors

    def vector(self, fit: JointFit) -> Array:
        """A fit's numbers, with zeros for numerical errors that it does not know."""
        return np.concatenate([fit.model.vector, np.zeros(self.errors - self.recorded)])

    def slopes(self, fit: JointFit, model: JointModel) -> tuple[Array, RandomEffects]:
        """Change (n, 6, q) over the numbers of `vector`, and noise and offsets of the trial."""
        there = joint_fit(self.white, self.numerical, model, rounds=0)
        numbers = 3 + len(fit.model.coordinates)
        wide = np.zeros((len(there.own), 6, numbers + self.errors))
        wide[:, :, :numbers] = there.shared[:, :, :numbers]
        wide[:, :, numbers + self.columns] = there.shared[:, :, numbers:]
        return wide, RandomEffects(there.own, wide[:, :, :0], there.precision[:0], there.starts)


def square_with(trial: TrialRows, pair: Recorded, truth: Array) -> float:
    """How far apart (in noise, squared) two explanations are in recorded data and trial together, the other refitted.

    Damped Gauss-Newton; where the first step keeps what its slopes promise there is no second.

    Parameters
    ----------
    truth : (n, 6)
        What the true one leaves of the trial's wrenches, from `TrialRows.residual`.
    """
    refit = _Refit(trial, pair, truth)
    vector = refit.start
    model = trial.model(pair.other, vector)
    apart = trial.residual(model) - truth
    for _ in range(ROUNDS):
        slopes, about = trial.slopes(pair.other, model)
        square = refit.square(vector, about.cost(apart))
        gram = refit.information + about.products(slopes, slopes)
        told = refit.pull(vector) + about.products(slopes, apart[:, :, None])[:, 0]
        change = bounded_change(gram, told, refit.low - vector, refit.high - vector)
        for _ in range(HALVINGS):
            promised = square - 2.0 * float(change @ told) + float(change @ gram @ change)
            tried = trial.model(pair.other, vector + change)
            left = trial.residual(tried) - truth
            reached = refit.square(vector + change, about.cost(left))
            if reached <= square:
                break
            change = change / 2.0
        else:
            return square
        vector, model, apart = vector + change, tried, left
        if reached - promised <= AS_PROMISED * max(promised, 1.0):
            return reached
    return reached


@dataclass(frozen=True)
class _Refit:
    trial: TrialRows
    pair: Recorded
    truth: Array

    @cached_property
    def fitted(self) -> Array:
        return self.trial.vector(self.pair.other)

    @cached_property
    def low(self) -> Array:
        return self._with_more(self.pair.other.model.bounds[0], -np.inf)

    @cached_property
    def high(self) -> Array:
        return self._with_more(self.pair.other.model.bounds[1], np.inf)

    @cached_property
    def information(self) -> Array:
        """Of the recorded data and of priors (q, q); numerical errors that they do not know have theirs."""
        size, known = len(self.fitted), len(self.pair.information)
        wide = np.eye(size)
        wide[:known, :known] = self.pair.information
        return wide

    @cached_property
    def gradient(self) -> Array:
        return self._with_more(self.pair.gradient, 0.0)

    @cached_property
    def start(self) -> Array:
        """Where the recorded data have it, E, nu and mu those of the truth as far as these leave them open."""
        near = np.zeros(len(self.fitted))
        near[:3] = NEAR**-2
        toward = np.zeros(len(self.fitted))
        toward[:3] = self.pair.truth.model.vector[:3] - self.pair.other.model.vector[:3]
        gram = self.information + np.diag(near)
        change = bounded_change(gram, self.gradient + near * toward, self.low - self.fitted, self.high - self.fitted)
        return self.fitted + change

    def square(self, vector: Array, of_trial: float) -> float:
        change = vector - self.fitted
        recorded = self.pair.square - 2.0 * float(self.gradient @ change) + float(change @ self.information @ change)
        return recorded + of_trial

    def pull(self, vector: Array) -> Array:
        pull: Array = self.gradient - self.information @ (vector - self.fitted)
        return pull

    def _with_more(self, known: Array, value: float) -> Array:
        return np.concatenate([known, np.full(self.trial.errors - self.trial.recorded, value)])
