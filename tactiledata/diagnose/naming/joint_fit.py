"""E, nu, mu, the strengths of effects and all nuisance at once, by damped Gauss-Newton that is linearised anew."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.linearise import Evaluation, Linearised, Sensitivities, inverse_of
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.parameters import JointModel, joint_model
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.nuisance.offsets import PRIOR

ROUNDS = 8
STILL = 0.05
"""Fall of the cost that ends a fit, in twice the log-likelihood: fits that zigzag are far from their end at 0.25."""
MOST_DAMPING = 1e2
BEHIND = 100.0
"""Cost beyond that of another explanation, from which it is asked whether a fit can still reach it."""


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


def joint_fit(
    cases: WhitenedTouches,
    numerical: Array,
    start: JointModel,
    held: Iterable[int] = (),
    rounds: int = ROUNDS,
    to_beat: float = np.inf,
) -> JointFit:
    """The model whose residual and priors are least, from a start.

    It is left where it is when it is far behind another explanation, and would stay so if all rounds that are left
    brought as much as the better of the last two: a round may stall on the way.

    Parameters
    ----------
    numerical : (N, 6, e)
        Whitened numerical errors, the same for all models that are compared.
    held : places of the vector that stay
    to_beat : float
        Cost of the other explanation.
    """
    work = Linearised(cases, numerical, frozenset(held))
    model, damping = start, 1e-3
    state = work.weighed(model)
    slopes, before = work.slopes(model, state), np.inf
    for left in range(rounds - 1, -1, -1):
        found = _stepped(work, model, state, slopes, damping)
        if found is None:
            break
        fell = state.cost - found[1].cost
        model, state, damping = found
        slopes = work.slopes(model, state)
        if fell < STILL or state.cost - left * max(fell, before) > to_beat + BEHIND:
            break
        before = fell
    plain = cases.touch_set.play(model.material, [], model.offsets)
    changed = cases.whiten(state.predicted.wrench - plain)
    return JointFit(
        model, state.cost, state.residual, slopes.shared, work.precision(model), work.centre(model), slopes.own,
        changed, cases.starts,
    )  # fmt: skip


def _stepped(
    work: Linearised, model: JointModel, state: Evaluation, slopes: Sensitivities, damping: float
) -> tuple[JointModel, Evaluation, float] | None:
    """A model that costs less, and the damping to go on with; none where no step promises that, or keeps it."""
    while damping < MOST_DAMPING:
        tried, promised = work.step(model, state, slopes, damping)
        if promised < STILL:
            return None
        after = work.weighed_or_none(tried)
        if after is not None and after.cost <= state.cost:
            return tried, after, max(damping / 10.0, 1e-6)
        damping *= 10.0
    return None


def plain_fit(white: WhitenedTouches, material: GelMaterial) -> JointFit:
    """E, nu, mu, offsets of trajectories and errors of the simulation, from a material to begin with."""
    numerical = white.simulation_error_fields(material)
    model = joint_model(material, [], len(white.starts), numerical.shape[2], box=white.touch_set.box)
    return joint_fit(white, numerical, model)
