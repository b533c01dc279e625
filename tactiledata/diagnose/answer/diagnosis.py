"""The diagnosis of a store: what was asked, what was found, and the verdict."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from tactiledata.contract.simulated import NOTHING_STATED, SimulatedCount
from tactiledata.diagnose.answer.sentences import Answer
from tactiledata.diagnose.formula.explain import Explanation
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
from tactiledata.diagnose.next_trial.propose import Proposal
from tactiledata.diagnose.options import DiagnosisOptions
from tactiledata.diagnose.touches.store_touches import StoreTouches
from tactiledata.diagnose.unseen.compare import HeldOutComparison
from tactiledata.diagnose.zeros.causes import ZeroCause

Verdict = Literal["nothing found", "explained", "partly explained", "not explained"]


@dataclass(frozen=True)
class StoreDiagnosis:
    """What a store's recordings say of their simulation.

    Parameters
    ----------
    store : str, digest of the store
    options : DiagnosisOptions
    played : StoreTouches
    naming : NamingResult
    shown : HeldOutComparison
    formula : Explanation, optional
        By a formula, of what no known effect explains.
    proposals : list of Proposal
        What to record next.
    limits : list of str
        What these recordings cannot tell, and which would.
    zeros : list of ZeroCause
        What the force sensor's zero follows.
    simulated : SimulatedCount
        Of the trajectories that were played.
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

    @property
    def answer(self) -> Answer:
        """What is said."""
        return Answer(self.naming)

    @property
    def is_missing(self) -> bool:
        """Whether physics is missing, of the contact or of the force sensor."""
        return self.answer.is_missing or bool(self.zeros)

    @property
    def verdict(self) -> Verdict:
        """In two words, the same as a table's."""
        if not self.is_missing:
            return "nothing found"
        if self.answer.names or not self.answer.is_missing:
            decision = self.naming.decision
            is_left = decision.is_more_left or decision.left.is_in_few(DEFAULT_THRESHOLDS)
            return "partly explained" if is_left else "explained"
        return "not explained"
