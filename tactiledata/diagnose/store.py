"""The diagnosis of a store: which physics its simulation lacks, where they differ, and what to record next."""

from __future__ import annotations

from collections.abc import Callable

from tactiledata.calibrate.measured import read_measured
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.calibrate.plays.learned_plays import example_touches
from tactiledata.compute import make_scheduler
from tactiledata.compute.base import Scheduler
from tactiledata.compute.threads import one_thread
from tactiledata.contract.extras import need_packages
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.diagnose.answer.diagnosis import StoreDiagnosis
from tactiledata.diagnose.answer.other_steps import materials_of_meshes
from tactiledata.diagnose.answer.sentences import Answer, preview_words
from tactiledata.diagnose.formula.explain import explain
from tactiledata.diagnose.naming.full_plays import named_with_full_plays
from tactiledata.diagnose.naming.kept_fits import KeptFits
from tactiledata.diagnose.naming.name_effects import NamingResult, name_effects, with_profiles
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.next_trial.limits import limits
from tactiledata.diagnose.next_trial.propose import propose_trials
from tactiledata.diagnose.options import DiagnosisOptions
from tactiledata.diagnose.touches.simulation_errors import NumericalErrors
from tactiledata.diagnose.touches.store_touches import StoreTouches, store_touches
from tactiledata.diagnose.unseen.compare import show
from tactiledata.diagnose.unseen.touch_residuals import case_residuals, locating, signature_fields
from tactiledata.diagnose.zeros.causes import no_zeros, zero_causes
from tactiledata.diagnose.zeros.coarse_steps import find_coarse_steps
from tactiledata.diagnose.zeros.dead_band import find_dead_band
from tactiledata.diagnose.zeros.inertia import find_inertia
from tactiledata.diagnose.zeros.readings import StoreReadings
from tactiledata.effects.touch.response import GelVariant
from tactiledata.errors import TactileDataError
from tactiledata.replay.opened import OpenedStore
from tactiledata.store.check.values import need_sound_values
from tactiledata.store.read.reader import Store
from tactiledata.store.read.simulated import simulated_trajectories

READ = ("contact_wrench", "wrench", "tcp", "joints")
"""Streams whose values must be sound before anything is read, whatever their source is called."""


def diagnose_store(
    store: Store,
    options: DiagnosisOptions,
    play_progress: Progress = no_progress,
    step_progress: Callable[[str], None] = lambda what: None,
    first_answer: Callable[[str], None] = lambda sentence: None,
    preview: Callable[[str], None] | None = None,
) -> StoreDiagnosis:
    """Return which physics the simulation of a store's touches lacks, where they differ, and what to record next.

    Parameters
    ----------
    store : Store
        Recordings.
    options : DiagnosisOptions
        Which trajectories and effects, and how the gel plays them.
    play_progress : Progress
        Called with how many plays of touches are finished, how many there are, and what was played last.
    step_progress : callable
        Called with a few words at the beginning of each later step.
    first_answer : callable
        Called with the first sentence of an answer from estimated plays, where gels have yet to be played in full.
    preview : callable, optional
        Called once with what the trajectories tell from which plays of the others are learned, as soon as these are
        played; at finite strain, where there are others. Their plays serve the whole diagnosis, too.

    Raises
    ------
    TactileDataError
        The store is damaged; too few trajectories can be used, and the message counts the reasons; or scikit-learn is
        not installed.
    """
    need_packages("a diagnosis", "sklearn")
    with make_scheduler(options.workers, options.scheduler).kept_open() as runner:
        return _diagnosed(store, options, runner, play_progress, step_progress, first_answer, preview)


def _diagnosed(
    store: Store,
    options: DiagnosisOptions,
    runner: Scheduler,
    play_progress: Progress,
    step_progress: Callable[[str], None],
    first_answer: Callable[[str], None],
    preview: Callable[[str], None] | None,
) -> StoreDiagnosis:
    """Return the diagnosis, with plays, refits and intervals on a scheduler; for the others see `diagnose_store`."""
    # check and read
    need_sound_values(store, [name for name in store.signal_names if name.partition("@")[0] in READ])
    calibration = options.calibration()
    opened = OpenedStore.planned(store, calibration.pads, calibration.indenter_folder)
    errors = NumericalErrors.of(options.fidelity)

    def play(full: frozenset[GelVariant]) -> StoreTouches:
        return store_touches(opened, calibration, play_progress, full, runner=runner)

    def candidates_of(played: StoreTouches) -> tuple[str, ...]:
        return tuple(name for name in played.effects if not options.effects or name in options.effects)

    def name(played: StoreTouches, kept: KeptFits | None = None) -> NamingResult:
        naming_options = NamingOptions(
            effects=candidates_of(played), errors=errors, pairs=options.pairs, seed=options.seed, profile=False
        )
        return name_effects(played.touch_set, played.start, naming_options, step_progress, kept, runner)

    # what the examples tell, whose plays come first
    if preview is not None and options.fidelity == "finite-strain":
        _preview(opened, calibration, play_progress, name, preview, runner)
    # name what is missing
    played, naming, full_plays = named_with_full_plays(play, name, lambda naming: first_answer(Answer(naming).what[0]))
    candidates = candidates_of(played)
    with one_thread():
        naming = with_profiles(naming, step_progress, runner)
        # compare on data that had no part in the fit
        shown = show(naming, options.seed, step_progress)
        # a formula where no known effect explains what is missing
        formula = None
        if Answer(naming).is_missing and not shown.names:
            step_progress("looking for a formula")
            residuals = case_residuals(naming.whitened, naming.base)
            known = signature_fields(
                naming.whitened, naming.base, [name for name in candidates if name not in naming.not_tried]
            )
            how = locating(naming.whitened, naming.base, options.seed)
            formula = explain(residuals, how, "seconds", signatures=known, located=shown.located, ceiling=shown.ceiling)
        step_progress("what to record next")
        proposals = propose_trials(naming)
    # limits of the recordings, causes of drifting zeros
    readings = StoreReadings(opened)
    free = readings.zeros()
    remarks = [*limits(played.touch_set, naming.base.model.material), *filter(None, [no_zeros(free)])]
    logged = readings.logged()
    dead_band = find_dead_band(logged)
    causes = zero_causes(free, options.seed, dead_band.force if dead_band else 0.0)
    shown_by_readings = dead_band or find_coarse_steps(logged), find_inertia(readings.moves(), options.seed)
    simulated = simulated_trajectories(store, played.uids)
    return StoreDiagnosis(
        store.digest,
        options,
        played,
        naming,
        shown,
        formula,
        proposals,
        remarks,
        causes,
        simulated,
        full_plays,
        tuple(filter(None, shown_by_readings)),
        materials_of_meshes(store),
    )


def _preview(
    opened: OpenedStore,
    calibration: CalibrationOptions,
    play_progress: Progress,
    name: Callable[[StoreTouches], NamingResult],
    tell: Callable[[str], None],
    runner: Scheduler,
) -> None:
    """Tell what the touches show from which plays of the others are learned, if there are others.

    Their changes by nu and by the offset are rough estimates, and other elastic laws are no candidates: the preview
    comes before these are played.

    Parameters
    ----------
    opened : OpenedStore
        Recordings.
    calibration : CalibrationOptions
        Which trajectories are drawn, and how the gel plays them.
    play_progress : Progress
        Called with how many plays of touches are finished.
    name : callable
        Names the effects that the simulation of touches lacks.
    tell : callable
        Called with a sentence or two, or with the reason why there are none.
    runner : Scheduler
        Where touches are played.
    """
    drawn = read_measured(opened, calibration).touches
    examples = [drawn[place].uid for place in example_touches([touch.touch for touch in drawn])]
    if len(examples) == len(drawn):
        return
    try:
        played = store_touches(opened, calibration, play_progress, only=examples, estimates="rough", runner=runner)
        tell(preview_words(name(played), len(drawn)))
    except TactileDataError as error:
        tell(f"There is no preview: {error.found}.")
