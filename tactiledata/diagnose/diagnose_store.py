"""`diagnose STORE`: read, play, name, locate, show, and what to record next."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from tactiledata.contract.simulated import NOTHING_STATED, SimulatedCount
from tactiledata.diagnose.answer import Answer
from tactiledata.diagnose.case_residuals import case_residuals, locating, signature_fields
from tactiledata.diagnose.evidence_scale import ESTIMATED
from tactiledata.diagnose.explain import Explanation, explain
from tactiledata.diagnose.force_zeros import read_zeros
from tactiledata.diagnose.learning_library import need_learning_library
from tactiledata.diagnose.name_effects import Naming, name_effects
from tactiledata.diagnose.naming_options import NamingOptions
from tactiledata.diagnose.next_trial import Proposal, propose_trials
from tactiledata.diagnose.recording_limits import limits
from tactiledata.diagnose.show import Shown, show
from tactiledata.diagnose.store_cases import StoreCases, store_cases
from tactiledata.diagnose.store_options import DiagnosisOptions
from tactiledata.diagnose.whitened_cases import NumericalErrors
from tactiledata.diagnose.zero_causes import ZeroCause, no_zeros, zero_causes
from tactiledata.store.reader import Store
from tactiledata.store.simulated import simulated_trajectories
from tactiledata.store.value_checks import need_sound_values

Tell = Callable[..., None]
READ = ("contact_wrench", "wrench", "tcp", "joints")
"""Streams that are read at their native rate, whatever their source is called."""
Verdict = Literal["nothing found", "explained", "partly explained", "not explained"]


@dataclass(frozen=True)
class StoreDiagnosis:
    """What a store's recordings say of their simulation.

    Parameters
    ----------
    store : str, digest of the store
    options : DiagnosisOptions
    played : StoreCases
    naming : Naming
    shown : Shown
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
    played: StoreCases
    naming: Naming
    shown: Shown
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
            is_left = decision.is_more_left or decision.left.is_in_few(ESTIMATED)
            return "partly explained" if is_left else "explained"
        return "not explained"


def diagnose_store(
    store: Store,
    options: DiagnosisOptions,
    playing: Tell = lambda done, total, what="": None,
    thinking: Callable[[str], None] = lambda what: None,
) -> StoreDiagnosis:
    """What the simulation of a store's touches lacks.

    Parameters
    ----------
    playing : callable
        Told how many of the plays are done.
    thinking : callable
        Told what is done with them.

    Raises
    ------
    TactileDataError
        The store is damaged; too few trajectories can be used, the message counts the reasons; or scikit-learn is not
        installed.
    """
    need_learning_library()
    need_sound_values(store, [name for name in store.signal_names if name.partition("@")[0] in READ])
    played = store_cases(store, options.calibration(), playing)
    wanted = tuple(name for name in played.effects if not options.effects or name in options.effects)
    errors = NumericalErrors.of(options.fidelity)
    asked = NamingOptions(effects=wanted, errors=errors, pairs=options.pairs, seed=options.seed)
    naming = name_effects(played.cases, played.start, asked, thinking)
    shown = show(naming, options.seed, thinking)
    formula = None
    if Answer(naming).is_missing and not shown.names:
        thinking("looking for a formula")
        residuals = case_residuals(naming.cases, naming.base)
        known = signature_fields(naming.cases, naming.base, [name for name in wanted if name not in naming.not_tried])
        how = locating(naming.cases, naming.base, options.seed)
        formula = explain(residuals, how, "seconds", signatures=known, located=shown.located)
    thinking("what to record next")
    proposals = propose_trials(naming)
    free = read_zeros(store)
    told = [*limits(played.cases, naming.base.model.material), *filter(None, [no_zeros(free)])]
    causes = zero_causes(free, options.seed)
    simulated = simulated_trajectories(store, played.uids)
    return StoreDiagnosis(store.digest, options, played, naming, shown, formula, proposals, told, causes, simulated)
