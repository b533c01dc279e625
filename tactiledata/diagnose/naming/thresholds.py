"""The numbers that turn evidence into a claim and into probabilities, all in one place.

Terms that these docstrings use; `tactiledata.diagnose.naming.evidence` has the formulas:

gain
    Rise of the log-likelihood on trajectories that were held out of the fit, over the dispersion.
evidence
    Logarithm of a Bayes factor against the plain simulation, where both are fitted to all trajectories.
signature statistic
    How much of an effect's change the residual holds, in standard errors between trajectories.
excess
    What the plain fit leaves beyond the noise: its sum of whitened squares less the sum that noise alone leaves.
mean square that is left
    Sum of whitened squares of held-out trajectories after the best fit, over the sum that noise alone leaves.
null
    A world that hides no effect, but whose contact another solver computed: the simulation errs by some per cent, and
    nothing is missing.
claim
    An effect, or two, that the answer names.

Errors of a simulation resemble some effects and not others: a solver of a gel at rest cannot err with the time since
power-on, but can with the stiffness of a stem. Therefore each effect needs an evidence of its own
(``CLAIM_EVIDENCE``), above what nulls of several generators brought it; docs/results.md has the measurement.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from tactiledata.arrays import Array, Mask
from tactiledata.effects import EFFECTS

CLAIM_EVIDENCE: Mapping[str, float] = MappingProxyType({
    "static_friction": 120.0, "arm_compliance": 40.0, "mount_offset": 40.0, "thickness": 35.0,
    "strain_stiffening": 35.0, "stem_bending": 40.0, "soft_region": 30.0, "dome": 30.0, "skin": 30.0,
    "area_friction": 30.0, "partial_slip": 30.0, "heating": 20.0, "mullins": 20.0, "wear": 20.0, "pad_edge": 20.0,
    "adhesion": 20.0, "gain_crosstalk": 70.0,
})  # fmt: skip
"""Evidence that an effect needs where errors of the simulation resemble it; the others need ``USUAL_CLAIM``."""
ALIKE_EVERYWHERE = frozenset({"static_friction"})
"""Effects that errors of the simulation resemble in every touch alike, so that touches agree on such an error, too:
solvers differ in how shear builds up before a contact slides."""
USUAL_CLAIM = 12.0
"""Evidence that an effect needs which errors of a simulation do not resemble."""
USUAL_CLAIMS: Mapping[str, float] = MappingProxyType({"rate_friction": 20.0})
"""Evidence that those of the other effects need which need more: solvers regularise friction in ways of their own."""
TYPICAL_OCCAM = 4.0
"""Occam penalty of an effect at the limit of what can be claimed, in units of evidence: a typical value."""


@dataclass(frozen=True)
class DecisionThresholds:
    """Thresholds of a claim, and the coefficients of the probabilities.

    Parameters
    ----------
    claims : dict, effect -> float
        Evidence that a claim of the effect needs, where it is not ``usual_claim``. The second of two named effects must
        add that evidence.
    usual_claim : float
        Evidence that a claim of any other effect needs.
    usual_claims : dict, effect -> float
        The same for effects that need more, though errors of the simulation do not resemble them.
    saturation : float
        Number α of trajectories of precision 1 from which the evidence that a claim needs is twice as large, for
        effects that errors of the simulation resemble: with t trajectories of precision q it is multiplied by
        1 + t q / α (`for_data`). Such an error is the same in every trajectory, and what it brings grows with the
        precision as well. Source: Miller and Dunson, JASA 114 (2019), the coarsened posterior.
    usual_saturation : float
        The same number for effects that errors of the simulation do not resemble.
    data : float
        Number of trajectories times their precision, t q; 0 before `for_data`.
    error_size : float
        Size of the simulation's errors beside a candidate, in the usual one; at least 1. What errors bring in forms
        that are not modelled grows with its third power: beyond ``usual_size``, so does the evidence that an effect
        needs which they resemble. Another effect needs it in proportion.
    usual_size : float
        Size of the simulation's errors up to which ``claims`` are enough.
    at_bound : float
        Multiple of the needed evidence that an effect needs which errors of the simulation resemble, where nu stands at
        an end of its range: the simulation follows these data with no plausible gel, and errs more than elsewhere.
    broad_share : float
        Share of the needed evidence that must remain without the two trajectories that contribute most.
    gain_sigmas : float
        Standard errors over trajectories that a gain, or a difference of two gains, needs to count as certain.
    certain_signature : float
        Signature statistic from which a positive gain is certain whatever its standard error: the gain of an effect
        that only fast touches show has a large one.
    signature_threshold : float
        Signature statistic from which trajectories agree on an effect before the refit. After the refit, a larger
        absolute value says that the effect has not removed what it should.
    decisive_signature : float
        Signature statistic from which the share of the excess no longer counts: what else the simulation lacks leaves
        an excess of its own.
    trend_sigmas, trend_share : float
        An effect whose strength changes during the session is not named: the change from the middle of the session to
        its end has so many standard errors, and is so large a share of the strength.
    least_excess_share : float
        Share of the excess that a claim must remove on indenters held out.
    main_cause_share : float
        Share of the excess that an effect which errors of the simulation resemble must remove where more than the
        stated noise is left beside it.
    part_share : float
        The same share for an effect that errors of the simulation do not resemble, unless it keeps its evidence beside
        all larger ones (`beside.stands_beside_larger`).
    whole_cause_share : float
        Share of the excess from which an effect that errors of the simulation do not resemble, or that shows as none of
        them does, is named even if its strength is beyond what is plausible.
    noise_dispersion : float
        Mean square that is left above which more than the stated noise is left.
    structure_dispersion : float
        Mean square that is left, without the two worst trajectories, above which the residual has structure.
    structure_evidence : float
        Multiple of the needed evidence from which a candidate that cannot be claimed shows that there is structure.
    tie : float
        Cosine of what two effects change, beyond what a refit imitates, above which these data cannot tell the two
        apart, as long as their evidence does not.
    tie_evidence, tie_share : float
        Lead in evidence up to which another candidate is a tie: the larger of a number, and of a share of the best
        candidate's evidence.
    crowd : int
        Number of other single effects with ``crowd_share`` of the evidence from which an effect that errors of the
        simulation resemble is not named: these data do not say which of them it is.
    crowd_share : float
        See ``crowd``.
    outweighed : float
        Multiple of the best candidate's evidence from which another single effect that cannot be claimed takes the name
        away, if it acts in the same slot, or if errors of the simulation resemble the best one and agreement does not
        tell it from them: what the data show most of is then something else.
    trace_share : float
        Share of the needed evidence that is enough for a trace.
    special_case_evidence : float
        Lead in evidence from which a special case with fewer numbers is preferred to the wider effect that contains
        it: errors of the simulation only ever speak for the wider one.
    wider_lead : float
        Multiple of the evidence that a wider effect needs by which it must lead a special case of it to be named.
    second_share : float
        The second of two effects only repairs an imperfect form of the first where it adds less than this share of the
        first one's evidence.
    remainder_share : float
        The second of two effects only repairs an imperfect form of the first where it adds less than this share of its
        own evidence alone and less than this share of the first one's. An effect stands beside another one, which only
        looks like errors of the simulation, where it adds this share of its own evidence.
    evidence_slope : float
        Log-odds of a candidate per unit of evidence beyond what it needs.
    unclaimed_cost : float
        Log-odds that a candidate loses if the answer neither claims it nor ties it with a claim.
    log_odds_nothing, log_odds_nothing_beside_structure : float
        Log-odds that no known effect is missing, relative to a claim that has just the evidence that it needs; where
        the residual has no structure, and where it has.
    log_odds_unlisted : float
        Log-odds of an effect outside the catalogue, relative to "nothing is missing", where the residual has
        structure; minus that number where it has none.
    beside_share : float
        Share of a candidate's probability that another effect is missing beside it which no refit tells.
    alike_share : float
        Share of a candidate's probability that something outside the catalogue is missing which is told to look like it
        (`tactiledata.effects.base.Effect.unlisted_look_alike`).
    """

    claims: Mapping[str, float] = field(default_factory=lambda: CLAIM_EVIDENCE)
    usual_claim: float = USUAL_CLAIM
    usual_claims: Mapping[str, float] = field(default_factory=lambda: USUAL_CLAIMS)
    saturation: float = 400.0
    usual_saturation: float = 1000.0
    data: float = 0.0
    error_size: float = 1.0
    usual_size: float = 1.26
    at_bound: float = 2.0
    broad_share: float = 0.5
    gain_sigmas: float = 2.0
    certain_signature: float = 4.0
    signature_threshold: float = 3.0
    decisive_signature: float = 7.0
    trend_sigmas: float = 4.0
    trend_share: float = 0.15
    least_excess_share: float = 0.05
    main_cause_share: float = 0.4
    whole_cause_share: float = 0.9
    part_share: float = 0.15
    noise_dispersion: float = 1.1
    structure_dispersion: float = 1.25
    structure_evidence: float = 2.0
    tie: float = 0.95
    tie_evidence: float = 8.0
    tie_share: float = 0.1
    crowd: int = 3
    crowd_share: float = 0.6
    outweighed: float = 1.5
    trace_share: float = 0.5
    special_case_evidence: float = 5.0
    wider_lead: float = 2.0
    second_share: float = 0.1
    remainder_share: float = 0.6
    evidence_slope: float = 0.02
    unclaimed_cost: float = 4.75
    log_odds_nothing: float = -1.9
    log_odds_nothing_beside_structure: float = -3.0
    log_odds_unlisted: float = 3.0
    beside_share: float = 0.2
    alike_share: float = 0.5

    def for_data(self, trajectories: int, precision: float = 1.0) -> DecisionThresholds:
        """Return the thresholds for a number of trajectories of a precision, `WhitenedTouches.precision`."""
        return replace(self, data=trajectories * precision)

    def with_errors(self, size: float) -> DecisionThresholds:
        """Return the thresholds beside errors of the simulation of a size, `error_sizes.typical_size`."""
        return replace(self, error_size=max(1.0, size))

    def unlike_errors(self, names: Sequence[str]) -> DecisionThresholds:
        """Return the thresholds where errors of the simulation are known not to be what looks like these effects."""
        return replace(self, claims={name: value for name, value in self.claims.items() if name not in names})

    def growth(self, names: Sequence[str]) -> float:
        """Return the factor on evidence that effects need: by the data, and by the size of the simulation's errors."""
        if self.is_resembled(names):
            return (1.0 + self.data / self.saturation) * max(1.0, self.error_size / self.usual_size) ** 3
        return (1.0 + self.data / self.usual_saturation) * self.error_size

    def claim(self, name: str) -> float:
        """Return the evidence that a claim of an effect needs."""
        usual = self.usual_claims.get(name, self.usual_claim)
        return self.claims.get(name, usual) * self.growth((name,))

    def is_resembled(self, names: Sequence[str]) -> bool:
        """Return whether errors of a simulation resemble one of these effects."""
        return any(name in self.claims for name in names)

    def is_told_by_agreement(self, names: Sequence[str]) -> bool:
        """Return whether agreement of all touches tells one effect from the errors of a simulation that resemble it."""
        return len(names) == 1 and self.is_resembled(names) and names[0] not in ALIKE_EVERYWHERE

    def cause_share(self, names: Sequence[str]) -> float:
        """Return the share of the excess that effects must remove where more than the stated noise is left."""
        return self.main_cause_share if self.is_resembled(names) else self.part_share

    def needed(self, names: Sequence[str]) -> float:
        """Return the evidence that a candidate of these effects needs."""
        return sum(self.claim(name) for name in names)

    def is_trend(self, share: float, standard_errors: float) -> bool:
        """Return whether a strength changes during the session, from `agreement.strength_trend`."""
        return abs(share) >= self.trend_share and abs(standard_errors) >= self.trend_sigmas

    def visible(self, name: str) -> float:
        """Return the signal-to-noise ratio s from which an effect can be claimed.

        The signal is the root of the sum of whitened squares of what the effect changes beyond what a refit imitates.
        The expected evidence is s²/2, less ``TYPICAL_OCCAM``.
        """
        return float(np.sqrt(2.0 * (self.claim(name) + TYPICAL_OCCAM)))

    @property
    def for_traces(self) -> DecisionThresholds:
        """Thresholds of a trace: the needed evidence is lowered by ``trace_share``."""
        lowered = {name: self.trace_share * value for name, value in self.claims.items()}
        usual = {name: self.trace_share * value for name, value in self.usual_claims.items()}
        return replace(self, claims=lowered, usual_claim=self.trace_share * self.usual_claim, usual_claims=usual)

    def tie_margin(self, evidence: float, names: Sequence[str]) -> float:
        """Return the lead in evidence up to which another candidate is a tie of one with this evidence.

        Parameters
        ----------
        evidence : float
            Evidence of the better candidate.
        names : sequence of str
            Effects of both.
        """
        return max(self.tie_evidence * self.growth(names), self.tie_share * evidence)

    def shares(self, beyond: Array, is_claimed: Mask, names: Sequence[Collection[str]], is_left: bool) -> Array:
        """Return probabilities (c + 3,): of c candidates, of another effect beside a candidate, of nothing, and of an
        effect outside the catalogue.

        They are the softmax of log-odds: ``evidence_slope`` times the evidence beyond what the candidate needs, over
        `growth`, less ``unclaimed_cost`` where it is not in the answer's set. Nothing and an effect outside the
        catalogue share the odds of ``log_odds_nothing``, or of ``log_odds_nothing_beside_structure``, as
        ``log_odds_unlisted`` says. Of each candidate, however large its evidence, ``alike_share`` goes to an effect
        outside the catalogue where one looks like it, and ``beside_share`` of the rest to another effect beside it.

        Parameters
        ----------
        beyond : (c,)
            Evidence of each candidate less the evidence that it needs, over its growth.
        is_claimed : (c,) bool
            Whether the answer claims the candidate, or ties it with a claim.
        names : c collections of str
            Effects of each candidate.
        is_left : bool
            Whether the best fit leaves structure.
        """
        odds = self.evidence_slope * beyond - self.unclaimed_cost * ~is_claimed
        unknown = self.log_odds_nothing_beside_structure if is_left else self.log_odds_nothing
        unlisted = self.log_odds_unlisted if is_left else -self.log_odds_unlisted
        values = np.concatenate([odds, [unknown - np.logaddexp(0.0, unlisted), unknown - np.logaddexp(0.0, -unlisted)]])
        # the largest exponent is 0: nothing overflows
        shares: Array = np.exp(values - values.max())
        return self.with_doubt(shares / shares.sum(), names)

    def with_doubt(self, shares: Array, names: Sequence[Collection[str]]) -> Array:
        """Return probabilities (c + 3,) as `shares` does, from those without another effect beside and without alikes.

        Parameters
        ----------
        shares : (c + 2,)
            Probabilities of c candidates, of nothing, and of an effect outside the catalogue.
        names : c collections of str
            Effects of each candidate.
        """
        has_alike = np.array([any(EFFECTS[name].unlisted_look_alike for name in each) for each in names], dtype=bool)
        alike = self.alike_share * has_alike * shares[:-2]
        beside = self.beside_share * (shares[:-2] - alike)
        nothing, other = shares[-2:]
        return np.concatenate([shares[:-2] - alike - beside, [beside.sum(), nothing, other + alike.sum()]])


DEFAULT_THRESHOLDS = DecisionThresholds()
"""The thresholds that every answer uses."""
