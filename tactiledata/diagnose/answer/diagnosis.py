"""The diagnosis of a store: options, results of every step, and the verdict."""

from __future__ import annotations

from dataclasses import dataclass

from tactiledata.contract.simulated import NOTHING_STATED, SimulatedCount
from tactiledata.diagnose.answer.other_steps import StatedMaterial
from tactiledata.diagnose.answer.sentences import Answer
from tactiledata.diagnose.formula.explain import Explanation
from tactiledata.diagnose.naming.decide import claim_verdict
from tactiledata.diagnose.naming.full_plays import FullPlay
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
from tactiledata.diagnose.next_trial.propose import Proposal
from tactiledata.diagnose.options import DiagnosisOptions
from tactiledata.diagnose.touches.store_touches import StoreTouches
from tactiledata.diagnose.unseen.compare import HeldOutComparison
from tactiledata.diagnose.verdict import Verdict
from tactiledata.diagnose.zeros.causes import ZeroCause
from tactiledata.diagnose.zeros.coarse_steps import CoarseSteps
from tactiledata.diagnose.zeros.dead_band import DeadBand
from tactiledata.diagnose.zeros.inertia import FreeAirInertia


@dataclass(frozen=True)
class StoreDiagnosis:
    """Everything that the diagnosis of a store found.

    Parameters
    ----------
    store : str
        Digest of the store.
    options : DiagnosisOptions
    played : StoreTouches
        The touches that took part, and what was left out.
    naming : NamingResult
        Which known effect the simulation lacks.
    shown : HeldOutComparison
        Errors on held-out data, and what locators find.
    formula : Explanation, optional
        A formula for what no known effect explains.
    proposals : list of Proposal
        Trials to record next, the best first.
    limits : list of str
        Sentences on what these recordings cannot show, and which recordings would.
    zeros : list of ZeroCause
        What the force sensor's zero follows in free air.
    simulated : SimulatedCount
        How many of the played trajectories are of simulated recordings.
    full_plays : tuple of FullPlay
        Effects that were played in full after an estimate, and how far the estimate was off.
    readings : tuple of DeadBand, CoarseSteps or FreeAirInertia
        What the force sensor's readings show by themselves.
    stated : tuple of StatedMaterial
        E, nu and mu of other steps, to be set beside those that were fitted.
    """

    store: str
    options: DiagnosisOptions
    played: StoreTouches
    naming: NamingResult
    shown: HeldOutComparison
    formula: Explanation | None
    proposals: list[Proposal]
    limits: list[str]
    zeros: list[ZeroCause]
    simulated: SimulatedCount = NOTHING_STATED
    full_plays: tuple[FullPlay, ...] = ()
    readings: tuple[DeadBand | CoarseSteps | FreeAirInertia, ...] = ()
    stated: tuple[StatedMaterial, ...] = ()

    @property
    def answer(self) -> Answer:
        """What the simulation lacks, by the known effects alone."""
        return Answer(self.naming)

    @property
    def is_missing(self) -> bool:
        """Whether physics is missing, of the contact or of the force sensor; a drift that does not matter is none."""
        return self.answer.is_missing or any(cause.matters for cause in self.zeros) or bool(self.readings)

    @property
    def verdict(self) -> Verdict:
        """The verdict on the store: that of the known effects, of a formula where these fail, or of the force sensor's
        readings alone.
        """
        if not self.is_missing or self.answer.names:
            return self.answer.verdict
        if not self.answer.is_missing:
            # the force sensor is explained; the contact may hold more
            decision = self.naming.decision
            return claim_verdict(decision.is_more_left, decision.left, DEFAULT_THRESHOLDS)
        by_formula = None if self.formula is None else self.formula.answer
        return by_formula if by_formula in (Verdict.EXPLAINED, Verdict.PARTLY_EXPLAINED) else self.answer.verdict
