"""Whether trajectories agree that a change is there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.held_out import GroupedCosts
from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.signatures import MATERIAL
from tactiledata.diagnose.naming.thresholds import DecisionThresholds
from tactiledata.diagnose.residuals.wording import quantity

MOST_ALONE = 0.98
"""Of what all tell, that one trajectory is taken to tell at most: one alone agrees with nobody."""


@dataclass(frozen=True)
class Agreement:
    """How much of a change there is, as trajectories say.

    A gain is a square, so that its spread over trajectories is mostly that of how much each can tell; here each weighs
    as much as it can tell, and the error is what they disagree by.

    Parameters
    ----------
    share : float
        Of the change, that is in the residual: 1 where all of it is, 0 where none.
    error : float
        Its standard error over trajectories.
    """

    share: float
    error: float

    @property
    def standard_errors(self) -> float:
        """By how many of them the share is not 0."""
        return self.share / self.error if self.error > 0 else 0.0


def agreement(metric: RandomEffects, change: Array, residual: Array) -> Agreement:
    """A change (N, 6) against a residual (N, 6), both whitened, beyond what the metric's refit imitates.

    Source: MacKinnon and White, Journal of Econometrics 29 (1985), HC3, here of trajectories.
    """
    weighed = metric.weigh(change[:, :, None])[:, :, 0]
    scores = np.add.reduceat((weighed * residual).sum(axis=1), metric.starts)
    told = np.add.reduceat((weighed * change).sum(axis=1), metric.starts)
    total = float(told.sum())
    if not total > 0:
        return Agreement(0.0, 0.0)
    share = float(scores.sum()) / total
    # what one trajectory tells is partly its own noise: the share without it, as in a jackknife
    alone = np.clip(told / total, 0.0, MOST_ALONE)
    spread = float((((scores - told * share) / (1.0 - alone)) ** 2).sum())
    return Agreement(share, float(np.sqrt(max(spread, 1e-300))) / total)


AT_BOUND = 0.01
"""Share of its bounds, that near to which a number stands at one."""
BEST = 2
"""Trajectories that a gain may not hang on: two of 25 gained 43 together in a world where nothing was missing."""
OF_INDENTERS = ("indenter_name", "mount")
"""Places of which a trajectory with another indenter tells nothing."""
STANDS_OUT = 2.0
"""Standard errors by which a number must be implausible to count against an effect."""


@dataclass(frozen=True)
class ScoredCandidate:
    """One effect, or two, beside the plain simulation.

    Parameters
    ----------
    fit : JointFit
    gains : (t,)
        Rise of the held-out log-likelihood of each trajectory, over the dispersion.
    indenter_gain, indenter_error : float
        The same over indenters; NaN where there is one only, or the effect has numbers of its own for each.
    excess_share : float
        Of what the plain fit leaves beyond the noise on indenters held out, the share that is gone; on trajectories
        where there is one indenter only, or each has numbers of its own.
    signature_before, signature_after : float
        Score along what the effect changes, over its standard error between trajectories, before and after the refit.
    implausible : tuple of str
        Numbers outside what can be believed.
    at_bounds : tuple of str
        Numbers at the end of what was tried.
    evidence : float
        Logarithm of the Bayes factor against the plain simulation where both are fitted to everything, over the
        dispersion: every frame speaks, and what is paid is what numbers can imitate.
    evidence_per_trajectory : (t,)
        What of it, before anything is paid, each trajectory brings.
    """

    fit: JointFit
    gains: Array
    indenter_gain: float
    indenter_error: float
    excess_share: float
    signature_before: float
    signature_after: float
    implausible: tuple[str, ...]
    at_bounds: tuple[str, ...]
    evidence: float
    evidence_per_trajectory: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Of the effects."""
        return self.fit.names

    @cached_property
    def label(self) -> str:
        """For tables."""
        return " + ".join(self.names) if self.names else "none"

    @property
    def gain(self) -> float:
        """Of all trajectories together."""
        return float(self.gains.sum())

    @property
    def gain_error(self) -> float:
        """Its standard error over trajectories."""
        return error_of_sum(self.gains)

    def gain_lower_bound(self, scale: DecisionThresholds) -> float:
        """By which candidates are ranked."""
        return scale.sure(self.gain, self.gain_error)

    @property
    def gain_without_best_two(self) -> float:
        """What is left of the gain without the trajectories that bring most."""
        return float(np.sort(self.gains)[:-BEST].sum())

    @property
    def evidence_without_best_two(self) -> float:
        """What is left of the evidence without the trajectories that bring most."""
        return self.evidence - float(np.sort(self.evidence_per_trajectory)[-BEST:].sum())

    def has_broad_support(self, scale: DecisionThresholds) -> bool:
        """Whether all trajectories together speak for it, without the best two still, and those held out not against.

        Nulls with a mismatched simulator have most of their evidence from two trajectories.
        """
        return (
            self.evidence >= scale.claim_gain
            and self.evidence_without_best_two >= scale.evidence_without_best_two
            and self.gain >= 0.5 * scale.claim_gain
        )

    def is_certain(self, scale: DecisionThresholds) -> bool:
        """Whether trajectories at large, and not one of them, speak for it.

        A gain is a square: an effect that only fast touches show has most of it from few of them, and a large error.
        The signature weighs each trajectory by what it can tell, so that it may be certain where the gain is not. And
        an effect of one place is under few touches: what is left without the best of them may be enough. Of all frames
        together something must be left without the best two in any case.
        """
        hangs_on_two = (
            self.evidence_without_best_two < scale.evidence_without_best_two
            and self.gain_without_best_two < scale.claim_gain
        )
        return not hangs_on_two and (
            self.gain >= scale.standard_errors * self.gain_error
            or self.signature_before >= scale.agreement
            or self.gain_without_best_two >= scale.claim_gain
            or self.has_broad_support(scale)
        )

    def is_agreed(self, scale: DecisionThresholds) -> bool:
        """Whether trajectories agree on its direction, or enough of them gain by it on their own."""
        return (
            self.signature_before >= scale.signature_threshold
            or self.gain_without_best_two >= scale.claim_gain
            or self.has_broad_support(scale)
        )

    def is_structure(self, scale: DecisionThresholds) -> bool:
        """Whether a gain that cannot be claimed is there for sure: not one that a single trajectory brings."""
        return self.gain >= 2.0 * scale.claim_gain and self.is_certain(scale)

    def is_trace(self, scale: DecisionThresholds) -> bool:
        """Whether it could be claimed if a share of what a claim needs were enough."""
        return not self.objections(scale.of_traces)

    def objections(self, scale: DecisionThresholds) -> tuple[str, ...]:
        """Why it cannot be claimed; empty where it can."""
        found = []
        if self.gain < scale.claim_gain and not self.has_broad_support(scale):
            found.append(
                f"held-out gain {self.gain:.1f}: simulators that differ by some per cent reach {scale.claim_gain:g}"
            )
        if not self.is_certain(scale):
            found.append(
                f"held-out gain {self.gain:.1f} with a standard error of {self.gain_error:.1f}, and evidence of"
                f" {self.evidence_without_best_two:.1f} without the two trajectories that bring most"
            )
        if self.excess_share < scale.excess:
            found.append(f"{100 * self.excess_share:.0f} % of the excess gone where it was not fitted")
        if not self.is_agreed(scale):
            found.append(f"trajectories do not agree on it ({self.signature_before:.1f} standard errors)")
        elif abs(self.signature_after) > max(scale.signature_threshold, 0.5 * self.signature_before):
            found.append("what it should cure is still there")
        return (*found, *(f"{name} is not plausible" for name in self.implausible))


def score_candidate(
    base: JointFit, fit: JointFit, base_out: GroupedCosts, out: GroupedCosts, expected: float, dispersion: float
) -> ScoredCandidate:
    """A refit beside the plain one.

    Parameters
    ----------
    expected : float
        Sum of whitened squares where noise is all there is.
    dispersion : float
        Mean square of what the best of all fits leaves: errors that no model explains make all evidence weaker.
    """
    gains = 0.5 * (base_out.by_trajectory - out.by_trajectory) / dispersion
    # what is another one for each indenter cannot be told of one that is held out
    is_told = len(out.by_indenter) > 0 and not any(
        setting.member.varies_by in OF_INDENTERS for setting in fit.model.settings
    )
    of_indenters = 0.5 * (base_out.by_indenter - out.by_indenter) / dispersion if is_told else np.zeros(0)
    groups = base_out.by_indenter if is_told else base_out.by_trajectory
    fitted = out.by_indenter if is_told else out.by_trajectory
    excess = float(groups.sum()) - expected
    before, after = (
        agreement(base.metric, fit.effect_change, residual).standard_errors
        for residual in (base.undone, _without(base, fit))
    )
    implausible, at_bounds = range_checks(fit)
    return ScoredCandidate(
        fit, gains, float(of_indenters.sum()) if is_told else float("nan"),
        error_of_sum(of_indenters), _share(float(groups.sum() - fitted.sum()), excess), before, after,
        implausible, at_bounds,
        0.5 * (base.cost - fit.cost) / dispersion - fit.occam,
        0.5 * (base.by_trajectory - fit.by_trajectory) / dispersion,
    )  # fmt: skip


def _share(gone: float, excess: float) -> float:
    """At most 1; of an excess within the noise, what is gone is all of it."""
    return gone / max(excess, abs(gone), 1e-300)


def error_of_sum(gains: Array) -> float:
    """Standard error of the sum of what trajectories gain; NaN of one alone."""
    return float(np.sqrt(len(gains)) * gains.std(ddof=1)) if len(gains) > 1 else float("nan")


def _without(base: JointFit, fit: JointFit) -> Array:
    """The plain fit's residual less what the effect changes."""
    return base.undone - fit.effect_change


def range_checks(fit: JointFit) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Numbers of a fit outside what can be believed, and those at the end of what was tried, for people."""
    errors = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))[3:]
    implausible, at_bounds = [], []
    gel, box = fit.model.material, fit.model.box
    for symbol, value, low, high in zip(
        MATERIAL, (gel.youngs_modulus, gel.poisson_ratio, gel.friction), box.low, box.high, strict=True
    ):
        if min(value - low, high - value) < AT_BOUND * (high - low):
            at_bounds.append(symbol)
    for one, error in zip(fit.model.coordinates, errors, strict=False):
        setting = fit.model.settings[one.place]
        value, name = setting.values[one.parameter.name], fit.model.name_of(one)
        low, high = one.bounds
        unit = one.to_unit(value)
        is_null = one.is_strength and value == one.parameter.null
        if not is_null and min(unit - low, high - unit) < AT_BOUND * (high - low):
            at_bounds.append(name)
        if not one.is_strength:
            continue
        if one.parameter.beyond(value) > STANDS_OUT * error * one.scale:
            implausible.append(f"{name} = {quantity(value, one.parameter.unit)}")
    return tuple(implausible), tuple(at_bounds)
