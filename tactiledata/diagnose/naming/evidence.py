"""How strongly the trajectories support a candidate: its gain, evidence and signature, and the objections to it.

A candidate is one effect, or a pair, refitted together with the material and all nuisance parameters, beside the plain
fit, which has the same parameters without any effect. Symbols, with t trajectories numbered by k and one common
dispersion φ:

gain
    G = Σ g_k with g_k = (p_k - c_k) / (2 φ). c_k is the sum of whitened squares of trajectory k under a candidate that
    was fitted without it, its own contact offset marginalised; p_k is the same of the plain fit. G is the rise of the
    log-likelihood on held-out data. Its standard error is √t times the sample standard deviation of the g_k.
evidence
    B = (P - C) / (2 φ) - O. C is the cost of the candidate fitted to all trajectories, whitened squares plus priors,
    and P is that of the plain fit. B approximates the logarithm of their Bayes factor. Errors of the simulation repeat
    in all trajectories: the evidence that a claim needs grows with their number (`DecisionThresholds.growth`).
Occam penalty
    O = ½ ln det(I + SᵀMS) + Σ ln m, the price of the candidate's free numbers (`JointFit.occam`). S is what one prior
    standard deviation of each strength changes in the whitened data, M the inverse covariance of the data with every
    other fitted number marginalised, and m the number of values that a screen tries for each shape parameter.
dispersion
    φ = max(1, mean square that the best fit leaves of held-out trajectories, over that of noise alone). Errors that no
    candidate explains weaken gain and evidence alike. O is not divided by it.
signature statistic
    Share of an effect's change that the residual holds, over its standard error between trajectories (`agreement`).
excess
    Sum of whitened squares that the plain fit leaves of held-out data, less the sum that noise alone leaves.
objection
    A sentence that says why a candidate cannot be claimed. A claim is a candidate without objections.
trace
    A candidate that would have no objections if a share of the gain and of the evidence were enough.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.agreement import Agreement, agreement
from tactiledata.diagnose.naming.held_out import GroupedCosts
from tactiledata.diagnose.naming.intervals import range_checks
from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.naming.signatures import POISSON_RATIO
from tactiledata.diagnose.naming.thresholds import DecisionThresholds

MOST_INFLUENTIAL = 2
"""Trajectories on which no claim may depend: two of 25 gained 43 together in a world where nothing was missing."""
INDENTER_PLACES = ("indenter_name", "mount")
"""Values of `Effect.varies_by` whose numbers differ by indenter: others say nothing about a held-out one."""


@dataclass(frozen=True)
class ScoredCandidate:
    """One effect, or a pair, with everything by which it is judged beside the plain fit.

    Parameters
    ----------
    fit : JointFit
        The refit with the effects, to all trajectories.
    gains : (t,)
        Gain g_k of each trajectory.
    indenter_gain, indenter_error : float
        Gain summed over held-out indenters and its standard error over them. Not a number where there is one indenter
        only, or where an effect has numbers of its own for each indenter.
    excess_share : float
        Share of the excess that is gone with the effects, on held-out indenters; on held-out trajectories where
        ``indenter_gain`` is not a number.
    signature_before, signature_after : float
        Signature statistic of what the effects change, in the residual of the plain fit and in that of the refit.
    implausible : tuple of str
        Strengths beyond what is plausible, as "name = value".
    at_bounds : tuple of str
        Names of fitted numbers that stand at a bound of the fit.
    evidence : float
        Evidence B, Occam penalty taken off.
    evidence_per_trajectory : (t,)
        Contribution of each trajectory to the evidence, before the Occam penalty and the priors of shared numbers.
    error_size : float
        Size of the simulation's errors beside the refit, in the usual one: what the effects explain is no error.
    trend : Agreement, optional
        How the strength of a single effect changes during the session, `agreement.strength_trend`; ``None`` where that
        is not known, or where the effect itself changes with what happened before.
    agreement_beside : dict, effect -> float
        Signature statistic of each effect of a pair beside the refit of the other one alone; empty for one effect.
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
    error_size: float = 1.0
    trend: Agreement | None = None
    agreement_beside: Mapping[str, float] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects of the candidate."""
        return self.fit.names

    @cached_property
    def label(self) -> str:
        """Names of the effects joined by " + ", as in tables; "none" without effects."""
        return " + ".join(self.names) if self.names else "none"

    @property
    def gain(self) -> float:
        """Gain G of all trajectories together."""
        return float(self.gains.sum())

    @property
    def gain_error(self) -> float:
        """Standard error of the gain over trajectories."""
        return error_of_sum(self.gains)

    @property
    def evidence_without_best_two(self) -> float:
        """Evidence that remains without the two trajectories that contribute most; the Occam penalty stays whole."""
        return self.evidence - float(np.sort(self.evidence_per_trajectory)[-MOST_INFLUENTIAL:].sum())

    def needed(self, thresholds: DecisionThresholds) -> float:
        """Return the evidence that a claim of the candidate needs beside the errors that the simulation then has.

        An effect that errors of the simulation resemble needs what the other effects need where it shows as no such
        error does (`is_confirmed`).
        """
        beside = thresholds.with_errors(self.error_size)
        if self.is_confirmed(thresholds):
            beside = beside.unlike_errors(self.names)
        return beside.needed(self.names)

    def is_confirmed(self, thresholds: DecisionThresholds) -> bool:
        """Whether an effect that errors of the simulation resemble shows in all trajectories, and on all indenters.

        Such an error does not, but for some (`DecisionThresholds.is_told_by_agreement`). The signature statistic of the
        plain fit's residual reaches ``decisive_signature``, and the gains on held-out trajectories and on held-out
        indenters both have ``gain_sigmas`` standard errors.
        """
        return (
            thresholds.is_told_by_agreement(self.names)
            and self.signature_before >= thresholds.decisive_signature
            and self.gain >= thresholds.gain_sigmas * self.gain_error > 0
            and self.indenter_gain >= thresholds.gain_sigmas * self.indenter_error > 0
        )

    def _remains(self, thresholds: DecisionThresholds, times: float = 1.0) -> bool:
        """Whether so many times the evidence that a claim needs beside usual errors remains without the best two."""
        return self.evidence_without_best_two >= times * thresholds.needed(self.names)

    def share_of_need(self, thresholds: DecisionThresholds) -> float:
        """Return the evidence beyond that which a claim needs, over the factor by which data and errors raise it."""
        growth = thresholds.with_errors(self.error_size).growth(self.names)
        return (self.evidence - self.needed(thresholds)) / growth

    def has_certain_gain(self, thresholds: DecisionThresholds) -> bool:
        """Whether there is a gain on held-out data, and it is more than chance.

        The gain on held-out trajectories is positive, and it has ``gain_sigmas`` standard errors, or the gain on
        held-out indenters has. Where much evidence remains without the two trajectories that contribute most, less is
        enough, since an effect that is much stronger in some trajectories than in others gains as unequally. One
        standard error is then certain; so is a gain whose sign one standard error leaves open, where that on held-out
        indenters has ``gain_sigmas`` standard errors. Much is ``structure_evidence`` times what a claim needs beside
        usual errors of the simulation, and what it needs beside those that there are.
        """
        remains_claimable = self.evidence_without_best_two >= self.needed(thresholds)
        is_much = remains_claimable and self._remains(thresholds, thresholds.structure_evidence)
        holds_on_indenters = self.indenter_gain >= thresholds.gain_sigmas * self.indenter_error
        if self.gain > 0:
            sigmas = 1.0 if is_much else thresholds.gain_sigmas
            return holds_on_indenters or self.gain >= sigmas * self.gain_error
        return is_much and holds_on_indenters and self.gain > -self.gain_error

    def is_certain(self, thresholds: DecisionThresholds) -> bool:
        """Whether there is a gain on held-out data, and it is more than chance.

        It is more than chance where it is certain (`has_certain_gain`), or where it is positive on held-out
        trajectories and the signature statistic reaches ``certain_signature``.
        """
        is_clear = self.gain > 0 and self.signature_before >= thresholds.certain_signature
        return is_clear or self.has_certain_gain(thresholds)

    def is_agreed(self, thresholds: DecisionThresholds) -> bool:
        """Whether trajectories agree on the effect.

        They do where the signature statistic of the plain fit's residual reaches ``signature_threshold``. They also do
        where the gain is certain (`has_certain_gain`) and the evidence that a claim needs remains without the two
        trajectories that contribute most to it.
        """
        return self.signature_before >= thresholds.signature_threshold or (
            self.has_certain_gain(thresholds) and self._remains(thresholds)
        )

    def beyond(self, thresholds: DecisionThresholds) -> float:
        """Return the evidence beyond that which a claim needs beside errors of the usual size: it ranks candidates.

        Larger errors of the simulation forbid claims. They are no reason to prefer another effect, which may imitate
        the one that they resemble.
        """
        return self.evidence - thresholds.needed(self.names)

    def is_decisive(self, thresholds: DecisionThresholds) -> bool:
        """Whether trajectories agree on the effect as they do on no error of the simulation.

        The signature statistic of the plain fit's residual reaches ``decisive_signature``, and the evidence that a
        claim needs remains without the two trajectories that contribute most. Other errors that are left beside such
        an effect do not speak against it.
        """
        return self.signature_before >= thresholds.decisive_signature and self._remains(thresholds)

    @property
    def is_worse_on_indenters(self) -> bool:
        """Whether indenters that were held out are predicted worse than by the plain simulation, beyond chance."""
        return self.indenter_gain + self.indenter_error < 0

    def is_structure(self, thresholds: DecisionThresholds) -> bool:
        """Whether the evidence is far beyond a claim's, even if no claim is possible: the residual has structure."""
        return self._remains(thresholds, thresholds.structure_evidence) and self.is_certain(thresholds)

    def is_trace(self, thresholds: DecisionThresholds) -> bool:
        """Whether there are no objections with the lowered thresholds of a trace."""
        return not self.objections(thresholds.for_traces)

    def objections(self, thresholds: DecisionThresholds) -> tuple[str, ...]:
        """Return sentences that say why the candidate cannot be claimed; empty where it can.

        There are ten: too little evidence; evidence from two trajectories; an uncertain gain; a larger error on
        indenters that were held out; too little of the excess gone on data that were not fitted; trajectories that do
        not agree; a signature that the refit has not removed; less than ``at_bound`` times the needed evidence where nu
        stands at an end of its range beside an effect that errors of the simulation resemble; a strength that changes
        during the session; and strengths that are not plausible, unless the effect is the whole cause
        (`is_whole_cause`).
        """
        needed, reasons = self.needed(thresholds), []
        if self.evidence < needed:
            reasons.append(
                f"the evidence is {self.evidence:.1f}, and errors of the simulation alone can bring up to {needed:.0f}"
            )
        if not self._remains(thresholds, thresholds.broad_share):
            reasons.append(
                f"the evidence is {self.evidence_without_best_two:.1f} without the two trajectories that contribute"
                " most"
            )
        if not self.is_certain(thresholds):
            reasons.append(
                f"the gain on held-out trajectories is {self.gain:.1f} with a standard error of {self.gain_error:.1f},"
                " and held-out indenters do not confirm it"
            )
        if self.is_worse_on_indenters:
            reasons.append("held-out indenters are predicted worse with it than without")
        if self.excess_share < thresholds.least_excess_share and not self.is_decisive(thresholds):
            reasons.append(
                f"only {100 * self.excess_share:.0f} % of the excess over the noise is gone in data that were not"
                " fitted"
            )
        if not self.is_agreed(thresholds):
            reasons.append(f"the trajectories do not agree on the effect ({self.signature_before:.1f} standard errors)")
        if abs(self.signature_after) > max(thresholds.signature_threshold, 0.5 * self.signature_before):
            reasons.append("the residual still holds the change that the effect should remove")
        at_bound = max(needed, thresholds.at_bound * thresholds.needed(self.names))
        if POISSON_RATIO in self.at_bounds and thresholds.is_resembled(self.names) and self.evidence < at_bound:
            reasons.append(
                f"{POISSON_RATIO} stands at an end of the range that was tried, where errors of the simulation bring up"
                f" to {at_bound:.0f}"
            )
        if self.trend is not None and thresholds.is_trend(self.trend.share, self.trend.standard_errors):
            first, last = 100 * (1.0 - self.trend.share), 100 * (1.0 + self.trend.share)
            reasons.append(
                f"its strength changes during the session, from {first:.0f} % of the fitted one in the first trajectory"
                f" to {last:.0f} % in the last: something else behaves like it"
            )
        if self.implausible and not self.is_whole_cause(thresholds):
            reasons.extend(f"{name} is not plausible" for name in self.implausible)
        return tuple(reasons)

    def is_whole_cause(self, thresholds: DecisionThresholds) -> bool:
        """Whether the effect is decisive, no error of the simulation shows as it does, and it leaves next to nothing.

        Such an effect is named whatever its strength: a range is an estimate of what is usual. Errors of the simulation
        do not resemble it, or it shows as none of them does (`is_confirmed`).
        """
        return (
            (not thresholds.is_resembled(self.names) or self.is_confirmed(thresholds))
            and self.is_decisive(thresholds)
            and self.excess_share >= thresholds.whole_cause_share
        )


def score_candidate(
    base: JointFit,
    fit: JointFit,
    base_out: GroupedCosts,
    out: GroupedCosts,
    expected: float,
    dispersion: float,
    error_size: float = 1.0,
) -> ScoredCandidate:
    """Return the scores of a refit beside the plain fit; the module's docstring has the formulas.

    Parameters
    ----------
    base, fit : JointFit
        The plain fit and the refit with effects, both to all trajectories.
    base_out, out : GroupedCosts
        Held-out squares of the plain fit and of the refit, over the same folds.
    expected : float
        Sum of whitened squares of all trajectories where noise is all there is.
    dispersion : float
        φ, at least 1.
    error_size : float
        Size of the simulation's errors beside the refit, `error_sizes.typical_size`.
    """
    gains = 0.5 * (base_out.by_trajectory - out.by_trajectory) / dispersion
    # numbers that differ by indenter cannot be predicted for an indenter that is held out
    has_indenter_gain = len(out.by_indenter) > 0 and not any(
        setting.member.varies_by in INDENTER_PLACES for setting in fit.model.settings
    )
    of_indenters = 0.5 * (base_out.by_indenter - out.by_indenter) / dispersion if has_indenter_gain else np.zeros(0)
    # the excess is taken from indenters where that is possible, from trajectories otherwise
    groups = base_out.by_indenter if has_indenter_gain else base_out.by_trajectory
    fitted = out.by_indenter if has_indenter_gain else out.by_trajectory
    excess = float(groups.sum()) - expected
    before = agreement(base.metric, fit.effect_change, base.residual_at_centre).standard_errors
    after = agreement(fit.beside, fit.effect_change, fit.residual_beside).standard_errors
    implausible, at_bounds = range_checks(fit)
    return ScoredCandidate(
        fit, gains, float(of_indenters.sum()) if has_indenter_gain else float("nan"),
        error_of_sum(of_indenters), _excess_share(float(groups.sum() - fitted.sum()), excess), before, after,
        implausible, at_bounds,
        0.5 * (base.cost - fit.cost) / dispersion - fit.occam,
        0.5 * (base.cost_by_trajectory - fit.cost_by_trajectory) / dispersion,
        error_size,
    )  # fmt: skip


def _excess_share(gone: float, excess: float) -> float:
    """Share of an excess that is gone, -1 to 1; where more is gone than the excess, the share is 1."""
    return gone / max(excess, abs(gone), 1e-300)


def error_of_sum(gains: Array) -> float:
    """Return the standard error of the sum of independent gains (t,); not a number for fewer than two."""
    return float(np.sqrt(len(gains)) * gains.std(ddof=1)) if len(gains) > 1 else float("nan")
