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
    A development world that hides no effect, but whose contact another solver computed: the simulation errs by some
    per cent, and nothing is missing.
claim
    An effect, or two, that the answer names.

Where the numbers come from: ``claim_gain`` is what 24 nulls did not gain in 95 of 100 cases. With all other conditions
kept, `benchmarks/naming_scale.py` reads 11 from a hundred nulls of 60 touches; the larger number stays, as weak effects
are otherwise named as others. ``evidence_slope``, ``objection_cost``, ``log_odds_nothing`` and ``log_odds_unlisted``
are what that benchmark fits to these nulls and to two worlds of each effect, rounded. The others are estimates from
worlds with hidden effects. They must be fitted anew, on more development worlds, before a claim is tested on sealed
worlds.

The fits were made with the noise of single readings. A frame lies between two readings and has two thirds of that
variance (decisions/0034). Numbers in units of evidence were since multiplied by 1.5, and numbers in units of noise by
the root of it, so that the same recordings give the same answers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from tactiledata.arrays import Array, Mask

Number = TypeVar("Number", float, Array)


@dataclass(frozen=True)
class DecisionThresholds:
    """Thresholds of a claim, and the coefficients of the probabilities.

    Parameters
    ----------
    claim_gain : float
        Gain that a claim needs. Also the evidence that it needs where its gain is small, and the evidence that the
        second of two named effects must add.
    gain_sigmas : float
        Standard errors over trajectories that a gain, or a difference of two gains, needs to count as certain.
    least_excess_share : float
        Share of the excess that a claim must remove on indenters held out.
    main_cause_share : float
        Share of the excess that a claim must remove where more than the stated noise is left beside it.
    noise_dispersion : float
        Mean square that is left above which more than the stated noise is left.
    signature_threshold : float
        Signature statistic from which trajectories agree on an effect before the refit; after the refit, a larger
        absolute value says that the effect has not removed what it should.
    certain_signature : float
        Signature statistic from which a gain is certain whatever its standard error.
    tie : float
        Cosine of what two effects change, beyond what a refit imitates, above which these data cannot tell
        the two apart.
    comparable_gain_share : float
        Share of the best candidate's gain from which another candidate without objections explains as much.
    rival_sigmas : float
        Standard errors of the difference by which the best must gain more than another candidate, where that one
        reaches ``claim_gain``; otherwise the other is listed as a tie. 1.3 is nine in ten of a normal distribution.
    evidence_without_best_two : float
        Evidence that must remain without the two trajectories that contribute most to it. Of nulls hardly any remains.
    trace_share : float
        Share of ``claim_gain`` and of ``evidence_without_best_two`` that is enough for a trace.
    special_case_evidence : float
        Lead in evidence from which a special case with fewer numbers is preferred to the wider effect that contains
        it: errors of the simulation only ever speak for the wider one.
    remainder_share : float
        The second of two effects only repairs an imperfect form of the first where it adds less than this share of its
        own evidence alone and less than this share of the first one's.
    structure_dispersion : float
        Mean square that is left, without the two worst trajectories, above which the residual has structure.
    evidence_slope : float
        Log-odds of a candidate per unit of its evidence. It is far below 1 because errors of the simulation bring
        evidence, too.
    objection_cost : float
        Log-odds that a candidate loses if it has an objection, or if it is a pair of which one effect suffices.
    log_odds_nothing : float
        Log-odds of "nothing is missing", relative to a candidate without evidence.
    gain_penalty_sigmas : float
        Standard errors over trajectories that are subtracted from a gain before candidates are ranked by it.
    log_odds_unlisted : float
        Log-odds of an effect outside the catalogue, relative to "nothing is missing", where the residual has
        structure; minus that number where it has none.
    """

    claim_gain: float = 39.0
    gain_sigmas: float = 2.0
    least_excess_share: float = 0.05
    main_cause_share: float = 0.5
    noise_dispersion: float = 1.05
    signature_threshold: float = 3.7
    certain_signature: float = 7.3
    tie: float = 0.95
    comparable_gain_share: float = 0.8
    rival_sigmas: float = 1.3
    evidence_without_best_two: float = 18.0
    trace_share: float = 0.5
    special_case_evidence: float = 7.5
    remainder_share: float = 0.6
    structure_dispersion: float = 1.25
    evidence_slope: float = 0.02
    objection_cost: float = 5.0
    log_odds_nothing: float = 0.5
    gain_penalty_sigmas: float = 1.2
    log_odds_unlisted: float = 4.8

    @property
    def visible(self) -> float:
        """Signal-to-noise ratio s from which an effect can be claimed: the expected gain s²/2 then is ``claim_gain``.

        The signal is the root of the sum of whitened squares of what the effect changes beyond what a refit imitates.
        """
        return float(np.sqrt(2.0 * self.claim_gain))

    @property
    def for_traces(self) -> DecisionThresholds:
        """Thresholds of a trace: ``claim_gain`` and ``evidence_without_best_two`` are lowered by ``trace_share``."""
        return replace(
            self,
            claim_gain=self.trace_share * self.claim_gain,
            evidence_without_best_two=self.trace_share * self.evidence_without_best_two,
        )

    def lower_bound(self, gain: Number, error: Number) -> Number:
        """Return a gain minus ``gain_penalty_sigmas`` standard errors: a gain from few trajectories ranks lower."""
        return gain - self.gain_penalty_sigmas * error

    def shares(self, evidence: Array, is_objected: Mask, is_left: bool) -> Array:
        """Return probabilities (c + 2,) of c candidates, then of nothing, then of an effect outside the catalogue.

        They are the softmax of log-odds: ``evidence_slope`` times the evidence, less ``objection_cost`` where something
        speaks against the candidate; ``log_odds_nothing`` for nothing; ``log_odds_nothing`` plus or minus
        ``log_odds_unlisted`` for an effect outside the catalogue.

        Parameters
        ----------
        evidence : (c,)
            Evidence of each candidate.
        is_objected : (c,) bool
            Whether the candidate has an objection, or is a pair of which one effect suffices.
        is_left : bool
            Whether the best fit leaves structure.
        """
        odds = self.evidence_slope * evidence - self.objection_cost * is_objected
        other = self.log_odds_nothing + (self.log_odds_unlisted if is_left else -self.log_odds_unlisted)
        values = np.concatenate([odds, [self.log_odds_nothing, other]])
        # the largest exponent is 0: nothing overflows
        shares: Array = np.exp(values - values.max())
        return shares / shares.sum()


DEFAULT_THRESHOLDS = DecisionThresholds()
"""The thresholds that every answer uses."""
