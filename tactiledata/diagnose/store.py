"""`diagnose STORE`: read, play, name, locate, show, and what to record next."""

from __future__ import annotations

from collections.abc import Callable

from tactiledata.contract.progress import Progress, no_progress
from tactiledata.diagnose.answer.diagnosis import StoreDiagnosis
from tactiledata.diagnose.answer.sentences import Answer
from tactiledata.diagnose.formula.explain import explain
from tactiledata.diagnose.naming.name_effects import name_effects
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.next_trial.limits import limits
from tactiledata.diagnose.next_trial.propose import propose_trials
from tactiledata.diagnose.options import DiagnosisOptions
from tactiledata.diagnose.residuals.learners import need_learning_library
from tactiledata.diagnose.touches.store_touches import store_touches
from tactiledata.diagnose.touches.whitened import NumericalErrors
from tactiledata.diagnose.unseen.compare import show
from tactiledata.diagnose.unseen.touch_residuals import case_residuals, locating, signature_fields
from tactiledata.diagnose.zeros.causes import no_zeros, zero_causes
from tactiledata.diagnose.zeros.readings import read_zeros
from tactiledata.store.check.values import need_sound_values
from tactiledata.store.read.reader import Store
from tactiledata.store.read.simulated import simulated_trajectories

READ = ("contact_wrench", "wrench", "tcp", "joints")
"""Streams that are read at their native rate, whatever their source is called."""


def diagnose_store(
    store: Store,
    options: DiagnosisOptions,
    playing: Progress = no_progress,
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
    played = store_touches(store, options.calibration(), playing)
    wanted = tuple(name for name in played.effects if not options.effects or name in options.effects)
    errors = NumericalErrors.of(options.fidelity)
    asked = NamingOptions(effects=wanted, errors=errors, pairs=options.pairs, seed=options.seed)
    naming = name_effects(played.touch_set, played.start, asked, thinking)
    shown = show(naming, options.seed, thinking)
    formula = None
    if Answer(naming).is_missing and not shown.names:
        thinking("looking for a formula")
        residuals = case_residuals(naming.whitened, naming.base)
        known = signature_fields(
            naming.whitened, naming.base, [name for name in wanted if name not in naming.not_tried]
        )
        how = locating(naming.whitened, naming.base, options.seed)
        formula = explain(residuals, how, "seconds", signatures=known, located=shown.located)
    thinking("what to record next")
    proposals = propose_trials(naming)
    free = read_zeros(store)
    told = [*limits(played.touch_set, naming.base.model.material), *filter(None, [no_zeros(free)])]
    causes = zero_causes(free, options.seed)
    simulated = simulated_trajectories(store, played.uids)
    return StoreDiagnosis(store.digest, options, played, naming, shown, formula, proposals, told, causes, simulated)
