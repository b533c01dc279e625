"""Distance of two explanations in recorded data and in a trial, after one has been refitted to the other."""

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
from tactiledata.diagnose.touches.simulation_errors import NumericalErrors
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches

NEAR = np.array([0.03, 0.005, 0.05])
"""Standard deviations of ln E, nu and mu about the true ones with which a refit starts. Recorded data may leave them
open, and slopes far from the truth mislead (without sliding the slope over friction is 0)."""
ROUNDS, HALVINGS = 4, 3
"""Gauss-Newton steps, and how often a step is halved that makes the distance larger."""
AS_PROMISED = 0.1
"""A step is the last one where the distance misses its linear prediction by at most this share of it, or this much."""


def error_probability(square: float) -> float:
    """Return the probability of choosing the wrong one of two explanations at a squared distance in noise."""
    return 0.5 * math.erfc(math.sqrt(max(square, 0.0)) / 2.0 / math.sqrt(2.0))


@dataclass(frozen=True)
class Recorded:
    """Squared distance in recorded data of two explanations, as a parabola of the other's q numbers.

    ``truth`` is taken to hold; ``other`` is refitted to its prediction.

    Parameters
    ----------
    truth, other : JointFit
        Fits to the same data.
    """

    truth: JointFit
    other: JointFit

    @cached_property
    def _about(self) -> RandomEffects:
        """Metric with noise and each trajectory's own offset; shared numbers stay free."""
        fit = self.other
        return RandomEffects(fit.own, fit.shared[:, :, :0], fit.precision[:0], fit.starts)

    @cached_property
    def _apart(self) -> Array:
        """Whitened difference (n, 6) of the two predictions."""
        return self.other.residual - self.truth.residual

    @cached_property
    def information(self) -> Array:
        """Information matrix (q, q) of the other's numbers, priors included."""
        shared = self.other.shared
        return self._about.products(shared, shared) + np.diag(self.other.precision)

    @cached_property
    def gradient(self) -> Array:
        """Downhill gradient (q,) of half the squared distance over the other's numbers."""
        return self._about.products(self.other.shared, self._apart[:, :, None])[:, 0]

    @cached_property
    def square(self) -> float:
        """Squared distance in noise with the numbers as fitted and each trajectory's offset refitted."""
        return self._about.cost(self._apart)

    @cached_property
    def least(self) -> float:
        """Squared distance in noise with all numbers of the other explanation refitted."""
        vector, (low, high) = self.other.model.vector, self.other.model.bounds
        change = bounded_change(self.information, self.gradient, low - vector, high - vector)
        return max(self.square - 2.0 * float(change @ self.gradient) + float(change @ self.information @ change), 0.0)


@dataclass(frozen=True)
class TrialRows:
    """The n whitened frames of a trial, and how its errors of the simulation correspond to those of recorded data.

    Parameters
    ----------
    white : WhitenedTouches
        The trial's touches.
    columns : (e,) int
        Place of each of the trial's errors of the simulation among those of the recorded data; indenters that were not
        recorded follow after these.
    errors, recorded : int
        Number of errors of the simulation in all, and in the recorded data.
    """

    white: WhitenedTouches
    columns: NDArray[np.int64]
    errors: int
    recorded: int

    @staticmethod
    def of(trial: TouchSet, recorded: WhitenedTouches) -> TrialRows:
        """Return the whitened frames of a trial, with the errors of the simulation that the recorded data have."""
        errors: NumericalErrors = recorded.errors
        white = WhitenedTouches.of(trial, errors)
        place_of = {(error.what, error.indenter): place for place, error in enumerate(recorded.simulation_errors)}
        known = len(place_of)
        for error in white.simulation_errors:
            place_of.setdefault((error.what, error.indenter), len(place_of))
        columns = np.array([place_of[error.what, error.indenter] for error in white.simulation_errors])
        return TrialRows(white, columns, len(place_of), known)

    def model(self, fit: JointFit, vector: Array) -> JointModel:
        """Return the model of a fit in the trial, at a vector of the fit's numbers and of all errors."""
        numbers = 3 + len(fit.model.coordinates)
        offsets = np.zeros(len(self.white.starts))
        there = replace(fit.model, offsets=offsets, errors=np.zeros(len(self.columns)))
        return there.at(np.concatenate([vector[:numbers], vector[numbers:][self.columns]]), offsets)

    def residual(self, model: JointModel) -> Array:
        """Return the whitened residual (n, 6) of a model against the wrenches of the plain simulation."""
        predicted = self.white.touch_set.simulate(model.material, model.settings, model.offsets)
        return self.white.residual(self.white.erred(predicted, model.errors))

    def vector(self, fit: JointFit) -> Array:
        """Return a fit's numbers, with zeros for errors of the simulation that only the trial has."""
        return np.concatenate([fit.model.vector, np.zeros(self.errors - self.recorded)])

    def slopes(self, fit: JointFit, model: JointModel) -> tuple[Array, RandomEffects]:
        """Return the whitened change (n, 6, q) over the numbers of `vector`, and the metric of noise and offsets."""
        there = joint_fit(self.white, model, rounds=0)
        numbers = 3 + len(fit.model.coordinates)
        wide = np.zeros((len(there.own), 6, numbers + self.errors))
        wide[:, :, :numbers] = there.shared[:, :, :numbers]
        wide[:, :, numbers + self.columns] = there.shared[:, :, numbers:]
        return wide, RandomEffects(there.own, wide[:, :, :0], there.precision[:0], there.starts)


def square_with(trial: TrialRows, pair: Recorded, truth: Array) -> float:
    """Return the squared distance, in noise, of two explanations in recorded data and trial together.

    The explanation that is not true is refitted by damped Gauss-Newton steps; they end with a step that reaches what
    its slopes predict.

    Parameters
    ----------
    trial : TrialRows
    pair : Recorded
        The two explanations in the recorded data.
    truth : (n, 6)
        Residual of the true explanation in the trial, from `TrialRows.residual`.
    """
    refit = _Refit(trial, pair, truth)
    vector = refit.start
    model = trial.model(pair.other, vector)
    apart = trial.residual(model) - truth
    for _ in range(ROUNDS):
        # a step within the bounds of the numbers
        slopes, about = trial.slopes(pair.other, model)
        square = refit.square(vector, about.cost(apart))
        gram = refit.information + about.products(slopes, slopes)
        gradient = refit.pull(vector) + about.products(slopes, apart[:, :, None])[:, 0]
        change = bounded_change(gram, gradient, refit.low - vector, refit.high - vector)
        # halved until the distance falls
        for _ in range(HALVINGS):
            promised = square - 2.0 * float(change @ gradient) + float(change @ gram @ change)
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
    """The refit of one explanation to the other: start, bounds, and its parabola in recorded data and priors."""

    trial: TrialRows
    pair: Recorded
    truth: Array

    @cached_property
    def fitted(self) -> Array:
        """Numbers (q,) of the other explanation as fitted to the recorded data."""
        return self.trial.vector(self.pair.other)

    @cached_property
    def low(self) -> Array:
        """Lower bounds (q,) of the numbers."""
        return self._with_more(self.pair.other.model.bounds[0], -np.inf)

    @cached_property
    def high(self) -> Array:
        """Upper bounds (q,) of the numbers."""
        return self._with_more(self.pair.other.model.bounds[1], np.inf)

    @cached_property
    def information(self) -> Array:
        """Information matrix (q, q) of recorded data and priors; errors that only the trial has bring their prior."""
        size, known = len(self.fitted), len(self.pair.information)
        wide = np.eye(size)
        wide[:known, :known] = self.pair.information
        return wide

    @cached_property
    def gradient(self) -> Array:
        """Downhill gradient (q,) at the fitted numbers, of recorded data and priors."""
        return self._with_more(self.pair.gradient, 0.0)

    @cached_property
    def start(self) -> Array:
        """Numbers (q,) at which the refit starts: the best in recorded data, E, nu and mu drawn towards the truth."""
        near = np.zeros(len(self.fitted))
        near[:3] = NEAR**-2
        toward = np.zeros(len(self.fitted))
        toward[:3] = self.pair.truth.model.vector[:3] - self.pair.other.model.vector[:3]
        gram = self.information + np.diag(near)
        change = bounded_change(gram, self.gradient + near * toward, self.low - self.fitted, self.high - self.fitted)
        return self.fitted + change

    def square(self, vector: Array, of_trial: float) -> float:
        """Return the squared distance at numbers (q,): recorded data and priors, plus that in the trial."""
        change = vector - self.fitted
        recorded = self.pair.square - 2.0 * float(self.gradient @ change) + float(change @ self.information @ change)
        return recorded + of_trial

    def pull(self, vector: Array) -> Array:
        """Return the downhill gradient (q,) at numbers (q,), of recorded data and priors."""
        pull: Array = self.gradient - self.information @ (vector - self.fitted)
        return pull

    def _with_more(self, known: Array, value: float) -> Array:
        """Return numbers (q,) made of those of the recorded data and a value for errors that only the trial has."""
        return np.concatenate([known, np.full(self.trial.errors - self.trial.recorded, value)])
