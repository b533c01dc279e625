"""Joint fit of material, effect strengths and all nuisance parameters: damped Gauss-Newton, linearised in each round.

The fit minimises the cost: the sum of squares of the whitened residual plus the squares that the priors add, which is
twice the negative logarithm of the posterior density up to a constant.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array, Indices, Mask
from tactiledata.diagnose.naming.linearise import Evaluation, Linearised, Sensitivities, inverse_of
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.parameters import JointModel, joint_model
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.nuisance.offsets import PRIOR

ROUNDS = 12
"""Largest number of rounds of a fit: each linearises once and takes one step."""
STILL = 0.05
"""A fit ends when a round lowers the cost by less than this. With 0.25, slow fits would end far from their minimum."""
MOST_DAMPING = 1e2
"""Relative damping of the normal equations at which a fit gives up looking for a step that lowers the cost."""
SHORTER = (0.3, 0.1, 0.03)
"""Shares of a step that are tried where the whole step raises the cost, before the damping grows."""
HALVINGS = 3
"""Largest number of times that the motion of contact offsets is halved before the whole step is damped."""
BEHIND = 100.0
"""A fit whose cost is above that of another explanation by more than this ends early if it is unlikely to catch up."""


@dataclass(frozen=True)
class JointFit:
    """The best fit of a model and its linearisation about the optimum; q numbers are shared by all trajectories.

    Parameters
    ----------
    model : JointModel
        The fitted numbers.
    cost : float
        Sum of squares of the whitened residual, and of all priors.
    residual : (N, 6)
        Whitened: measured less predicted.
    shared : (N, 6, q)
        Whitened change of the wrench over each entry of the model's vector.
    precision, centre : (q,)
        Inverse variance and mean of the prior of each entry; precision 0 where there is no prior.
    own : (N, 6)
        Whitened change over one standard deviation of the trajectory's contact offset.
    effect_change : (N, 6)
        Whitened wrench with the effects less the wrench without them, all else as fitted.
    starts : (t,)
        First row of each trajectory.
    """

    model: JointModel
    cost: float
    residual: Array
    shared: Array
    precision: Array
    centre: Array
    own: Array
    effect_change: Array
    starts: Indices

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects in the model, each once."""
        return tuple(dict.fromkeys(setting.effect for setting in self.model.settings))

    @property
    def effect_fields(self) -> Array:
        """Whitened change (N, 6, c) over each of the effects' c numbers: a part of ``shared``."""
        return self.shared[:, :, 3 : 3 + len(self.model.coordinates)]

    @property
    def simulation_error_fields(self) -> Array:
        """Whitened change (N, 6, e) over one deviation of each error of the simulation: a part of ``shared``."""
        return self.shared[:, :, 3 + len(self.model.coordinates) :]

    @property
    def by_row(self) -> Array:
        """Contact offset (N, 1) of each row's trajectory, in standard deviations of its prior."""
        counts = np.diff(self.starts, append=len(self.own))
        return np.repeat(self.model.offsets / PRIOR, counts)[:, None]

    @property
    def cost_by_trajectory(self) -> Array:
        """Part (t,) of the cost that is each trajectory's own: its residual and the prior of its offset."""
        squares: Array = np.add.reduceat((self.residual**2).sum(axis=1), self.starts)
        return squares + (self.model.offsets / PRIOR) ** 2

    @property
    def metric(self) -> RandomEffects:
        """Metric in which changes that a refit of this model could imitate count as 0, linearised at the optimum.

        Entries that stand at a bound could not move in a refit, and are left out.
        """
        vector, (low, high) = self.model.vector, self.model.bounds
        edge = 1e-6 * np.maximum(1.0, np.abs(vector))
        inside = (vector > low + edge) & (vector < high - edge)
        return RandomEffects(self.own, self.shared[:, :, inside], self.precision[inside], self.starts)

    @property
    def residual_at_centre(self) -> Array:
        """Whitened residual (N, 6) with offsets and entries that have a prior moved back to its mean, to first order.

        `metric` marginalises these numbers, so that scores in it need the residual that they have not yet reduced.
        """
        return self._moved_back(np.ones(len(self.precision), dtype=bool))

    @property
    def residual_beside(self) -> Array:
        """`residual_at_centre`, but with the effects as fitted; in the metric `beside` it shows what they leave."""
        return self._moved_back(~self._is_of_effects)

    def _moved_back(self, chosen: Mask) -> Array:
        """Whitened residual (N, 6) with offsets and chosen entries (q,) that have a prior moved back to its mean."""
        vector, (low, high) = self.model.vector, self.model.bounds
        edge = 1e-6 * np.maximum(1.0, np.abs(vector))
        goes_back = chosen & (self.precision > 0) & (vector > low + edge) & (vector < high - edge)
        back = np.where(goes_back, vector - self.centre, 0.0)
        return self.residual + self.own * self.by_row + self.shared @ back

    @property
    def _is_of_effects(self) -> Mask:
        """Entries of the vector (q,) that are numbers of effects."""
        is_of_effects = np.zeros(self.shared.shape[2], dtype=bool)
        is_of_effects[3 : 3 + len(self.model.coordinates)] = True
        return is_of_effects

    @property
    def beside(self) -> RandomEffects:
        """Metric in which changes that E, nu, mu, offsets and errors of the simulation could imitate count as 0."""
        others = ~self._is_of_effects
        return RandomEffects(self.own, self.shared[:, :, others], self.precision[others], self.starts)

    @cached_property
    def occam(self) -> float:
        """Occam penalty of the effects' numbers: ½ ln det(I + SᵀMS) + Σ ln m.

        S (N, 6, s) is the whitened change over one prior standard deviation of each strength, M the inverse covariance
        with every other fitted number marginalised, and m the number of grid values of each shape parameter. The
        determinant says how much narrower the data make the strengths than their priors were; ln m is the price of
        having chosen the best of m shapes.

        Source: Laplace's approximation of a Bayes factor, as in MacKay, Neural Computation 4 (1992).
        """
        coordinates = self.model.coordinates
        strengths = self.effect_fields[:, :, [coordinate.is_strength for coordinate in coordinates]]
        narrowed = np.eye(strengths.shape[2]) + self.beside.products(strengths, strengths)
        shapes = sum(np.log(len(shape.parameter.grid)) for shape in coordinates if not shape.is_strength)
        return float(0.5 * np.linalg.slogdet(narrowed)[1] + shapes)

    @property
    def covariance(self) -> Array:
        """Posterior covariance (q, q) of the model's vector, contact offsets marginalised."""
        about = RandomEffects(self.own, self.shared[:, :, :0], self.precision[:0], self.starts)
        return inverse_of(about.products(self.shared, self.shared) + np.diag(self.precision))


def joint_fit(
    whitened: WhitenedTouches,
    start: JointModel,
    held: Iterable[int] = (),
    rounds: int = ROUNDS,
    to_beat: float = np.inf,
) -> JointFit:
    """Return the fit with the least cost that is reached from a start.

    The fit ends early if its cost is far above that of another explanation and would remain so even if every round that
    is left lowered it by as much as the better of the last two rounds did.

    Parameters
    ----------
    whitened : WhitenedTouches
        Measured trajectories.
    start : JointModel
        Where the fit starts; without errors of the simulation where it has none.
    held : iterable of int
        Entries of the model's vector that do not move.
    rounds : int
        Largest number of rounds; 0 only linearises about the start.
    to_beat : float
        Cost of the other explanation; infinite where there is none.

    Raises
    ------
    UsageError
        Gel and springs find no balance at the start.
    """
    work = Linearised(whitened, frozenset(held))
    model, state, slopes = _descended(work, start, rounds, to_beat)
    slopes = slopes or work.slopes(model, state)
    plain = whitened.touch_set.play(model.material, [], model.offsets)
    changed = whitened.whiten(state.predicted.wrench - plain)
    return JointFit(
        model, state.cost, state.residual, slopes.shared, work.precision(model), work.centre(model), slopes.own,
        changed, whitened.starts,
    )  # fmt: skip


def least_cost(whitened: WhitenedTouches, start: JointModel, held: Iterable[int], rounds: int) -> float:
    """Return the cost of the fit that `joint_fit` would return, without the linearisation about it.

    Parameters
    ----------
    whitened, start, held, rounds
        As in `joint_fit`.
    """
    return _descended(Linearised(whitened, frozenset(held)), start, rounds)[1].cost


def _descended(
    work: Linearised, start: JointModel, rounds: int, to_beat: float = np.inf
) -> tuple[JointModel, Evaluation, Sensitivities | None]:
    """The model with the least cost that is reached, its evaluation, and its derivatives where they were needed."""
    model, damping, before = start, 1e-3, np.inf
    state, slopes = work.evaluate(model), None
    for left in range(rounds - 1, -1, -1):
        slopes = work.slopes(model, state)
        better = _better(work, model, state, slopes, damping)
        if better is None:
            break
        fell = state.cost - better[1].cost
        model, state, damping = better
        slopes = None
        if fell < STILL or state.cost - left * max(fell, before) > to_beat + BEHIND:
            break
        before = fell
    return model, state, slopes


def _better(
    work: Linearised, model: JointModel, state: Evaluation, slopes: Sensitivities, damping: float
) -> tuple[JointModel, Evaluation, float] | None:
    """A model with a cost that is not higher, its evaluation and the next damping; ``None`` where no step leads to one.

    Parameters
    ----------
    damping : float
        Relative damping of the first step; ten times more after each step that raises the cost.
    """
    before = work.costs(model, state.residual)
    while damping < MOST_DAMPING:
        tried, promised = work.step(model, state, slopes, damping)
        if promised < STILL:
            return None
        after = work.evaluate_or_none(tried)
        for _ in range(HALVINGS):
            if after is None or after.cost <= state.cost:
                break
            # an offset is far from linear where contact begins: where it made its trajectory worse, it moves less
            is_worse = work.costs(tried, after.residual) > before
            halved = 0.5 * (model.offsets + tried.offsets)
            tried = replace(tried, offsets=np.where(is_worse, halved, tried.offsets))
            after = work.evaluate_or_none(tried)
        if after is not None and after.cost <= state.cost:
            return tried, after, max(damping / 10.0, 1e-6)
        shorter = _shorter(work, model, state, tried)
        if shorter is not None:
            return *shorter, damping
        damping *= 10.0
    return None


def _shorter(
    work: Linearised, model: JointModel, state: Evaluation, tried: JointModel
) -> tuple[JointModel, Evaluation] | None:
    """A model on the way to a step that raises the cost, at which the cost is lower; ``None`` where there is none."""
    for share in SHORTER:
        between = model.at(
            model.vector + share * (tried.vector - model.vector),
            model.offsets + share * (tried.offsets - model.offsets),
        )
        after = work.evaluate_or_none(between)
        if after is not None and after.cost < state.cost - STILL:
            return between, after
    return None


def plain_fit(
    whitened: WhitenedTouches, material: GelMaterial, fitted: Callable[..., JointFit] = joint_fit
) -> JointFit:
    """Return the fit without effects, from a start material: E, nu, mu, contact offsets, errors of the simulation.

    Parameters
    ----------
    whitened : WhitenedTouches
        Measured trajectories.
    material : GelMaterial
        Where the fit starts.
    fitted : callable
        Makes the fit, as `joint_fit`.
    """
    errors = len(whitened.simulation_errors)
    return fitted(whitened, joint_model(material, [], len(whitened.starts), errors, box=whitened.touch_set.box))
