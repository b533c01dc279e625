"""`diagnose`: where simulation and recordings differ, which physics is missing, and how much better it fits."""

from __future__ import annotations

import dataclasses
import shlex
from pathlib import Path
from typing import Any

import typer

from tactiledata.cli.documents import (
    calibration_document,
    made_of_another_store,
    refuse_result_of_another_store,
    wrong_document_is_wrong_usage,
)
from tactiledata.cli.given_values import (
    INDENTERS,
    listed_names,
    need_folder,
    need_seed,
    need_writable_folder,
    refuse_given,
)
from tactiledata.cli.output import JSON_OPTION, emit, err, plain, progress, say
from tactiledata.cli.task_options import scheduler_option, workers_of, workers_option
from tactiledata.cli.working_store import working_store
from tactiledata.contract.extras import GEL, PAGE, need_packages

TABLES = (".csv", ".tsv", ".parquet")
"""Endings of files that are read as tables."""
TABLE_ONLY = ("columns", "group")
"""Options that have a meaning for tables only."""
STORE_ONLY = (
    "trajectories", "sensor", "indenter", "effects", "pairs", "fidelity", "bounds", "shore_a", "indenters", "workers",
    "scheduler", "calibration", "replace",
)  # fmt: skip
"""Options that have a meaning for stores only."""
STEPS = 30
"""Rough number of steps after the simulations, for the bar of progress."""


def register(app: typer.Typer) -> None:
    """Add the command `diagnose` to the application."""
    app.command("diagnose")(diagnose)


def diagnose(
    context: typer.Context,
    source: str = typer.Argument(
        None,
        help="A store (*.zarr) or a table (.csv, .tsv, .parquet). Default: the only store in the working folder.",
    ),
    out: Path = typer.Option(None, "--out", help="Folder for report.html and diagnosis.json."),
    gate: bool = typer.Option(False, "--gate", help="Exit with code 1 where physics is missing."),
    seed: int = typer.Option(0, "--seed", help="Random seed for drawing trajectories, folds and sign flips."),
    trajectories: int = typer.Option(
        60, "--trajectories", help="Store: number of trajectories that are drawn from it."
    ),
    sensor: str = typer.Option(None, "--sensor", help="Store: use only trajectories of this sensor."),
    indenter: str = typer.Option(
        None, "--indenter", help="Store: use only trajectories of these indenters: ball3,ball5."
    ),
    effects: str = typer.Option(None, "--effects", help="Store: consider only these effects: lag,relaxation."),
    pairs: bool = typer.Option(True, "--pairs/--no-pairs", help="Store: also consider pairs of effects."),
    fidelity: str = typer.Option(
        "finite-strain", "--fidelity", help="Store: strain model, finite-strain, or linear for a quick preview."
    ),
    bounds: str = typer.Option(
        "paper", "--bounds", help="Store: limits of mu, 0.5 to 0.99 (paper) or 0.2 to 1.5 (wide)."
    ),
    shore_a: float = typer.Option(24.5, "--shore-a", help="Store: Shore A hardness of the gel, where fits start."),
    indenters: Path = typer.Option(None, "--indenters", help="Store: folder of the mesh files that recordings name."),
    calibration: Path = typer.Option(
        None, "--calibration", help="Store: calibration.json whose E, nu and mu the page sets beside its own fit."
    ),
    replace: bool = typer.Option(
        False, "--replace", help="Store: replace a diagnosis of another store in the same folder."
    ),
    workers: int = workers_option("Store: "),
    scheduler: str = scheduler_option("Store: "),
    columns: Path = typer.Option(None, "--columns", help="Table: YAML file that states the meaning of the columns."),
    group: str = typer.Option(
        None, "--group", help="Table: column whose value is shared by rows that were recorded together."
    ),
    as_json: bool = JSON_OPTION,
) -> None:
    """Find the physics that a simulation lacks.

    Shows where recordings reveal missing physics, and how much better the simulation predicts unseen touches with it.

    Example: tactiledata diagnose ds.zarr --out diagnosis
    """
    # refuse wrong usage before any work
    need_packages("a diagnosis", "sklearn", *PAGE)
    is_table = source is not None and (Path(source).suffix in TABLES or Path(source).is_file())
    given, other = ("a table", "a store") if is_table else ("a store", "a table")
    refuse_given(context, STORE_ONLY if is_table else TABLE_ONLY, f"with {given}", f"with {other}")
    if out is not None:
        need_writable_folder(out, "report.html", "diagnosis.json", "effects.json")
        if not is_table:
            _need_own_trials(out)
    need_seed(seed)
    calibrated = None if calibration is None else (calibration_document(calibration), calibration.name)
    # diagnose
    if is_table:
        document, written, is_found = _table(Path(source), out, seed, columns, group, as_json)
    else:
        need_packages("a diagnosis of a store", *GEL)
        from tactiledata.diagnose.options import DiagnosisOptions

        options = DiagnosisOptions(
            trajectories=trajectories,
            fidelity=fidelity,  # type: ignore[arg-type]
            bounds=bounds,
            shore_a=shore_a,
            sensor=sensor,
            indenters=() if indenter is None else tuple(listed_names(indenter, "--indenter")),
            effects=() if effects is None else tuple(listed_names(effects, "--effects")),
            pairs=pairs,
            seed=seed,
            workers=workers_of(workers, scheduler),
            scheduler=scheduler,
            indenter_folder=need_folder(indenters, "--indenters", INDENTERS),
        )
        location = working_store(source)
        document, written, is_found = _store(location, out, options, calibrated, as_json, replace)
    # print
    if as_json:
        emit(document)
    else:
        for sentence in document["sentences"]:
            say(sentence)
        for note in document["notes"]:
            say(f"note: {note}")
        if written:
            say(f"written: {', '.join(str(path) for path in written)}")
        for path in written:
            if path.name == "effects.json" and not is_table:
                command = shlex.join(["tactiledata", "replay", location, "--effects", str(path)])
                say(f"next, every touch played with what was found: {command}")
    if gate and is_found:
        raise typer.Exit(1)


def _need_own_trials(out: Path) -> None:
    """Refuse a folder for the scenarios of trials that cannot be written to, or files of others in it."""
    from tactiledata.diagnose.answer.earlier_files import NEXT, trial_files

    need_writable_folder(out / NEXT, *(trial_files() if (out / NEXT).exists() else ()))


def _table(
    path: Path, out: Path | None, seed: int, columns: Path | None, group: str | None, quiet: bool
) -> tuple[dict[str, Any], list[Path], bool]:
    """Diagnose a table; return the document, the files written, and whether anything was found."""
    from tactiledata.contract.schema import read_document
    from tactiledata.diagnose.answer.earlier_files import remove_earlier
    from tactiledata.diagnose.table import diagnose_table, write_diagnosis

    meant = None
    if columns is not None:
        with wrong_document_is_wrong_usage():
            meant = read_document(columns, "columns")
    with progress("diagnosing", quiet=quiet) as report_progress:
        read, explanation, document = diagnose_table(path, meant, group, seed, report_progress)
    if out is None:
        return document, [], explanation.is_found
    remove_earlier(out, ())
    written = list(write_diagnosis(out, path.name, read, explanation, document))
    return document, written, explanation.is_found


def _store(
    location: str, out: Path | None, options: Any, calibrated: tuple[Any, str] | None, quiet: bool, replace: bool
) -> tuple[dict[str, Any], list[Path], bool]:
    """Diagnose a store; return the document, the files written, and whether physics is missing."""
    from tactiledata.cli.explain import damage_explains
    from tactiledata.diagnose.answer.documents import store_document, write_store_diagnosis
    from tactiledata.diagnose.answer.other_steps import material_of_calibration
    from tactiledata.diagnose.store import diagnose_store
    from tactiledata.ingest.checks.twins import need_touches_once
    from tactiledata.store.read.reader import Store

    with damage_explains(location), progress("diagnosing", quiet=quiet) as report_progress:
        store = Store.open(location)
        if out is not None:
            refuse_result_of_another_store(out / "diagnosis.json", store, replace)
        need_touches_once(store, options.sensor)
        # one bar for both: the simulations, whose number becomes known, and about STEPS steps after them
        steps: list[str] = []
        plays = [1]

        def report_play(done: int, total: int, what: str = "") -> None:
            """Report how many simulations are done."""
            plays[0] = total
            report_progress(done, total + STEPS, what)

        def report_step(what: str) -> None:
            """Report one more step after the simulations."""
            steps.append(what)
            report_progress(plays[0] + min(len(steps), STEPS - 1), plays[0] + STEPS, what)

        def tell(sentence: str) -> None:
            """Print the first answer while gels on which it could rest are played in full."""
            if not quiet:
                err().print(plain(f"First answer, from estimated plays: {sentence} The rest is played in full now."))

        def tell_preview(words: str) -> None:
            """Print what a few trajectories show while the others are played."""
            if not quiet:
                err().print(plain(words))

        diagnosis = diagnose_store(store, options, report_play, report_step, tell, tell_preview)
        report_progress(plays[0] + STEPS, plays[0] + STEPS, "done")
    if calibrated is not None:
        stated = material_of_calibration(*calibrated, made_of_another_store(calibrated[0], store))
        diagnosis = dataclasses.replace(diagnosis, stated=(*diagnosis.stated, stated))
    document = store_document(diagnosis)
    written = [] if out is None else write_store_diagnosis(out, Path(location).name, diagnosis, document)
    return document, written, diagnosis.is_missing
