"""`diagnose`: where simulation and recordings differ, what physics was left out, and how much better it then fits."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import typer

from tactiledata.cli.documents import wrong_document_is_wrong_usage
from tactiledata.cli.given_values import listed_names
from tactiledata.cli.output import JSON_OPTION, emit, progress, say
from tactiledata.cli.working_store import working_store
from tactiledata.errors import UsageError

TABLES = (".csv", ".tsv", ".parquet")
TABLE_ONLY = ("columns", "group")
STORE_ONLY = (
    "trajectories", "sensor", "indenter", "effects", "pairs", "fidelity", "bounds", "shore_a", "indenters", "workers",
)  # fmt: skip
SEEDS = 2**32
"""So many are known to all that draws by them."""
STEPS = 30
"""About so many steps follow the plays."""


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    app.command("diagnose")(diagnose)


def diagnose(
    context: typer.Context,
    source: str = typer.Argument(
        None, help="A store (*.zarr), or a table (.csv, .tsv, .parquet); left out: the only store in the folder."
    ),
    out: Path = typer.Option(None, "--out", help="Folder for report.html and diagnosis.json."),
    gate: bool = typer.Option(False, "--gate", help="Exit 1 where physics is missing."),
    seed: int = typer.Option(0, "--seed", help="Another seed draws other trajectories, and throws other chances."),
    trajectories: int = typer.Option(60, "--trajectories", help="Store: so many are drawn from it."),
    sensor: str = typer.Option(None, "--sensor", help="Store: only trajectories of this sensor."),
    indenter: str = typer.Option(None, "--indenter", help="Store: only those of these indenters: ball3,ball5."),
    effects: str = typer.Option(None, "--effects", help="Store: only these candidates: lag,relaxation."),
    pairs: bool = typer.Option(True, "--pairs/--no-pairs", help="Store: whether two effects at once are tried."),
    fidelity: str = typer.Option("finite-strain", "--fidelity", help="Store: finite-strain, or linear: a preview."),
    bounds: str = typer.Option("paper", "--bounds", help="Store: mu from 0.5 to 0.99 (paper), or 0.2 to 1.5 (wide)."),
    shore_a: float = typer.Option(24.5, "--shore-a", help="Store: the gel's Shore A hardness: where fits start."),
    indenters: Path = typer.Option(None, "--indenters", help="Store: folder of the mesh files that recordings name."),
    workers: int = typer.Option(1, "--workers", min=1, help="Store: local processes that play touches."),
    columns: Path = typer.Option(None, "--columns", help="Table: a YAML file that says what the columns mean."),
    group: str = typer.Option(None, "--group", help="Table: column that says which rows were recorded in one go."),
    as_json: bool = JSON_OPTION,
) -> None:
    """What physics a simulation lacks, and where recordings show it.

    Shows how much better the simulation with it tells touches that it has not seen.

    Example: tactiledata diagnose ds.zarr --out diagnosis
    """
    is_table = source is not None and (Path(source).suffix in TABLES or Path(source).is_file())
    _refuse(context, STORE_ONLY if is_table else TABLE_ONLY, "a table" if is_table else "a store")
    out = None if out is None else _writable(out)
    if not 0 <= seed < SEEDS:
        raise UsageError(f"--seed {seed}", f"0 or more, below {SEEDS}", "Any of them serves.")
    if is_table:
        document, written, is_found = _table(Path(source), out, seed, columns, group, as_json)
    else:
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
            workers=workers,
            indenter_folder=_folder(indenters),
        )
        document, written, is_found = _store(working_store(source), out, options, as_json)
    if as_json:
        emit(document)
    else:
        for sentence in document["sentences"]:
            say(sentence)
        for note in document["notes"]:
            say(f"note: {note}")
        if written:
            say(f"written: {', '.join(str(path) for path in written)}")
    if gate and is_found:
        raise typer.Exit(1)


def _refuse(context: typer.Context, names: tuple[str, ...], given: str) -> None:
    """Options that mean nothing to what is diagnosed.

    Raises
    ------
    UsageError
        One of them was given.
    """
    for name in names:
        source = context.get_parameter_source(name)
        if source is not None and source.name == "COMMANDLINE":
            option = f"--{name.replace('_', '-')}"
            raise UsageError(
                f"{option} with {given}", f"{option} with {'a store' if given == 'a table' else 'a table'}",
                "Leave it out: it would change nothing.",
            )  # fmt: skip


def _folder(path: Path | None) -> Path | None:
    if path is not None and not path.is_dir():
        raise UsageError(f"--indenters {path} is no folder", "the folder of the mesh files that recordings name")
    return path


def _writable(out: Path) -> Path:
    """The folder for the answer, before any work is done for it.

    Raises
    ------
    UsageError
        Nothing can be written there.
    """
    nearest = next(place for place in (out, *out.absolute().parents) if place.exists())
    if not nearest.is_dir() or not os.access(nearest, os.W_OK) or (out / "report.html").is_dir():
        raise UsageError(f"--out {out} cannot be written to", "a folder, or a place for one", "Name another.")
    return out


def _table(
    path: Path, out: Path | None, seed: int, columns: Path | None, group: str | None, quiet: bool
) -> tuple[dict[str, Any], list[Path], bool]:
    from tactiledata.contract.schema import read_document
    from tactiledata.diagnose.table import diagnose_table, write_diagnosis

    meant = None
    if columns is not None:
        with wrong_document_is_wrong_usage():
            meant = read_document(columns, "columns")
    with progress("diagnosing", quiet=quiet) as tell:
        read, explanation, document = diagnose_table(path, meant, group, seed, tell)
    written = [] if out is None else list(write_diagnosis(out, path.name, read, explanation, document))
    return document, written, explanation.is_found


def _store(location: str, out: Path | None, options: Any, quiet: bool) -> tuple[dict[str, Any], list[Path], bool]:
    from tactiledata.cli.explain import damage_explains
    from tactiledata.diagnose.answer.documents import store_document, write_store_diagnosis
    from tactiledata.diagnose.store import diagnose_store
    from tactiledata.store.read.reader import Store

    with damage_explains(location), progress("diagnosing", quiet=quiet) as tell:
        steps: list[str] = []
        plays = [1]

        def playing(done: int, total: int, what: str = "") -> None:
            plays[0] = total
            tell(done, total + STEPS, what)

        def thinking(what: str) -> None:
            steps.append(what)
            tell(plays[0] + min(len(steps), STEPS - 1), plays[0] + STEPS, what)

        done = diagnose_store(Store.open(location), options, playing, thinking)
        tell(plays[0] + STEPS, plays[0] + STEPS, "done")
    document = store_document(done)
    written = [] if out is None else write_store_diagnosis(out, Path(location).name, done, document)
    return document, written, done.is_missing
