"""The numbers by which evidence becomes a probability and a claim; in one place, and to be fitted.

``claim`` is what 24 nulls, whose contact another solver computed, did not gain in 95 of 100 cases. With all other
conditions kept, as `benchmarks/naming_scale.py` reads a hundred nulls of 60 touches, 11 would do; it stays, as weak
effects then go by the names of others. ``slope``, ``objected``, ``none`` and ``other`` are what that benchmark makes of
these nulls and of two worlds of each effect, rounded. The rest are estimates from worlds with planted effects. Fit them
anew on more development worlds before a claim is held against sealed ones.

The fits were made with the noise of single readings; a frame lies between two readings and has two thirds of that
variance (decisions/0034). Numbers in units of evidence were since multiplied by 1.5, those in units of noise by the
root of it, so that the same recordings give the same answers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array

Number = TypeVar("Number", float, Array)


@dataclass(frozen=True)
class DecisionThresholds:
    """Thresholds and slopes.

    Parameters
    ----------
    claim_gain : float
        Held-out gain, in units of log-likelihood over the dispersion, that nulls with a mismatched simulator do not
        reach in 95 of 100 cases.
    standard_errors : float
        That the held-out gain must have of its own standard error over trajectories.
    excess : float
        Share of what is left beyond the noise that must vanish on indenters held out.
    explains : float
        Share of the excess that what is claimed must explain where more than the stated noise is left beside it.
    noise : float
        Mean square of what is left, over that of noise, from which it is more than the stated noise.
    signature_threshold : float
        Signature statistic above which an effect is seen, and below which it is cured.
    agreement : float
        Signature statistic from which the held-out gain need not have its standard errors.
    tie : float
        Cosine of projected signatures beyond which two effects are told apart by nothing.
    as_good : float
        Share of the best one's gain from which another, which could be claimed as well, explains as much.
    rival : float
        Standard errors over trajectories by which the best one must gain more than another, whose gain reaches the
        claim, for the other not to be listed: nine in ten of a normal distribution.
    evidence_without_best_two : float
        Evidence that must be left without the two trajectories that bring most; of nulls hardly any is.
    trace : float
        Share of the gain and the evidence that a claim needs, with which a candidate is a trace.
    needless : float
        Evidence by which a special case of another, with fewer numbers, is preferred to it: errors of the simulation
        only ever speak for the wider one.
    remainder : float
        Share of its own evidence, and of that of the first of two effects, below which what the second adds is what an
        imperfect form of the first leaves.
    dispersion : float
        Mean square of what is left, over that of noise, that is no structure yet.
    slope : float
        Log-odds of a candidate's probability per unit of its evidence.
    objected : float
        Log-odds that an objection costs, or in a pair an effect that adds nothing of its own.
    none : float
        Log-odds of nothing, over a candidate without evidence.
    gain_penalty_sigmas : float
        Standard errors over trajectories that are taken off a gain before candidates are ranked by it: what hangs on
        few touches comes after what all bring.
    other : float
        Log-odds, over nothing, of an effect that is not in the catalogue where structure is left; as much against it
        where none is.
    """

    claim_gain: float = 39.0
    standard_errors: float = 2.0
    excess: float = 0.05
    explains: float = 0.5
    noise: float = 1.05
    signature_threshold: float = 3.7
    agreement: float = 7.3
    tie: float = 0.95
    as_good: float = 0.8
    rival: float = 1.3
    evidence_without_best_two: float = 18.0
    trace: float = 0.5
    needless: float = 7.5
    remainder: float = 0.6
    dispersion: float = 1.25
    slope: float = 0.02
    objected: float = 5.0
    none: float = 0.5
    gain_penalty_sigmas: float = 1.2
    other: float = 4.8

    @property
    def visible(self) -> float:
        """Signal over noise whose gain, half its square, reaches the claim."""
        return float(np.sqrt(2.0 * self.claim_gain))

    @property
    def of_traces(self) -> DecisionThresholds:
        """What a trace needs."""
        return replace(
            self,
            claim_gain=self.trace * self.claim_gain,
            evidence_without_best_two=self.trace * self.evidence_without_best_two,
        )

    def sure(self, gain: Number, error: Number) -> Number:
        """A gain less so many of its standard errors: what hangs on few touches comes after what all bring."""
        return gain - self.gain_penalty_sigmas * error

    def shares(self, evidence: Array, is_objected: NDArray[np.bool_], is_left: bool) -> Array:
        """Probabilities (c + 2,) of candidates, then of none and of an effect that is not in the catalogue.

        Parameters
        ----------
        evidence : (c,)
            Logarithms of Bayes factors.
        is_objected : (c,) bool
            Whether something speaks against claiming a candidate.
        is_left : bool
            Whether structure is left.
        """
        odds = self.slope * evidence - self.objected * is_objected
        other = self.none + (self.other if is_left else -self.other)
        values = np.concatenate([odds, [self.none, other]])
        shares: Array = np.exp(values - values.max())
        return shares / shares.sum()


DEFAULT_THRESHOLDS = DecisionThresholds()
