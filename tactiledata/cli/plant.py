"""`plant`: a known effect in a copy of a store, with a sealed label, and the score of a diagnosis of the copy."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from tactiledata.cli.given_values import refuse_given
from tactiledata.cli.output import JSON_OPTION, emit, progress, say
from tactiledata.cli.working_store import working_store
from tactiledata.contract.extras import GEL, need_packages
from tactiledata.contract.own_files import refuse_foreign
from tactiledata.errors import StoreError, UsageError

if TYPE_CHECKING:
    from tactiledata.prove.plant.planting import Planting

SIZELESS = ("any", "nothing")
"""Words after --effect that leave no size to state: chance draws both, or nothing is planted."""


def register(app: typer.Typer) -> None:
    """Add the command `plant` to the application."""
    app.command("plant")(plant)


def plant(
    context: typer.Context,
    store: str = typer.Argument(None, help="A store (*.zarr). Default: the only store in the working folder."),
    effect: str = typer.Option(
        None,
        "--effect",
        help="lag, frame_rotation, drift, dead_band, gain, added_mass, thickness, nothing; any leaves it to chance.",
    ),
    size: float = typer.Option(None, "--size", help="Size in the effect's SI unit. Default: drawn, and not printed."),
    into: Path = typer.Option(None, "--into", help="Where the copy is written."),
    score: Path = typer.Option(
        None, "--score", help="Open the label of this copy, and score its diagnosis (--diagnosis)."
    ),
    diagnosis: Path = typer.Option(None, "--diagnosis", help="With --score: diagnosis.json of the copy."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Plant a known effect into a copy of a store.

    The label is sealed beside the copy: COPY.seal.json may be published, COPY.label.json is kept from whoever
    diagnoses.

    Example: tactiledata plant ds.zarr --effect any --into blind.zarr
    """
    if score is not None:
        refuse_given(context, ["effect", "size", "into"], "with --score", "without --score")
        _score(score, diagnosis, as_json)
        return
    if effect is None or into is None or diagnosis is not None:
        raise UsageError(
            "--diagnosis without --score" if diagnosis is not None else "no --effect, or no --into",
            "--effect NAME --into COPY, or --score COPY --diagnosis FILE",
            "For example: tactiledata plant ds.zarr --effect lag --into planted.zarr",
        )
    if effect in SIZELESS:
        refuse_given(context, ["size"], f"with --effect {effect}", "with the name of an effect")
    _plant(working_store(store), effect, size, into, as_json)


def _plant(location: str, effect: str, size: float | None, into: Path, as_json: bool) -> None:
    """Plant an effect into a copy of a store, or go on with a copy that was begun."""
    need_packages("planting an effect", *GEL)
    from tactiledata.prove.plant.label import drawn_planting, seal_files, write_label
    from tactiledata.prove.plant.planting import need_readings, plant_into
    from tactiledata.prove.seal.folder import read_json
    from tactiledata.store.read.reader import Store

    store = Store.open(location)
    need_readings(store)
    planting = _begun_planting(into)
    if planting is None:
        if into.exists():
            raise UsageError(
                f"--into {into} exists, and `tactiledata plant` did not write it",
                "a place for a new store",
                "Name another folder.",
            )
        planting = drawn_planting(effect, size)
        write_label(into, planting)
    elif effect not in ("any", planting.effect) or size not in (None, planting.size):
        raise UsageError(
            f"{into} was begun with another effect or size", "the same options", "Name another folder for the copy."
        )
    seal_file, label_file = seal_files(into)
    commitment = read_json(seal_file)["commitment"]
    with progress("planting", quiet=as_json) as report_progress:
        notes = plant_into(store, into, planting, commitment, report_progress)
    if as_json:
        emit({"copy": str(into), "seal": str(seal_file), "label": str(label_file), "commitment": commitment})
        return
    say(f"{into} is a copy with an effect planted, or nothing. Commitment: {commitment}")
    say(f"Keep {label_file} from whoever diagnoses the copy; {seal_file} may be published.")
    for note in notes:
        say(f"note: {note}")


def _begun_planting(into: Path) -> Planting | None:
    """Return what an interrupted call began to plant; refuse labels and seals of others, and one without the other."""
    from tactiledata.prove.plant.label import FORMAT, kept_planting, seal_files

    files = seal_files(into)
    for path in files:
        refuse_foreign(path, FORMAT.encode())
    there, gone = ([path for path in files if path.exists() is wanted] for wanted in (True, False))
    if there and gone:
        raise UsageError(
            f"{there[0]} is there, and {gone[0].name} is not beside it",
            "both, of a copy that was begun, or neither",
            f"Put {gone[0].name} back beside it, or name another place with --into.",
        )
    try:
        return kept_planting(into)
    except (KeyError, TypeError) as error:
        raise StoreError(
            f"{files[1]} holds no label that can be read",
            "the label that was sealed",
            "Name another place with --into.",
        ) from error


def _score(copy: Path, diagnosis: Path | None, as_json: bool) -> None:
    """Open the label of a copy and say whether its diagnosis names what was planted."""
    from tactiledata.prove.plant.label import score_planting

    if diagnosis is None:
        raise UsageError(
            "--score without --diagnosis", "both", "tactiledata diagnose COPY --out DIR writes DIR/diagnosis.json."
        )
    found = score_planting(copy, diagnosis)
    if as_json:
        emit(found)
        return
    size = f", {found['size']:g} {found['unit']}" if found["unit"] else ""
    said = ", ".join([*found["names"], *found["ties"], *found["zeros"]]) or "no name"
    say(f"Planted: {found['planted']}{size}. Said: {found['verdict']}, {said}. That is: {found['outcome']}.")
