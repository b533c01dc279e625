"""`record`: play a scenario and write ordinary logs of it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import typer

if TYPE_CHECKING:
    from tactiledata.rig.record import Form

from tactiledata.cli.documents import wrong_document_is_wrong_usage
from tactiledata.cli.given_values import need_writable_folder
from tactiledata.cli.output import JSON_OPTION, emit, progress, say
from tactiledata.cli.task_options import WORKERS
from tactiledata.contract.atomic import FULL, REFUSED, refusal
from tactiledata.contract.own_files import LOG, refuse_foreign
from tactiledata.contract.wording import counted
from tactiledata.contract.worker_pool import need_workers
from tactiledata.errors import TactileDataError, UsageError

TRUTH_MARKS = {".json": b'"unsettled_steps"', ".parquet": b"stamp_ns"}
"""Names that files of the truth hold, by the ending of their names: they carry no mark."""
PICTURE = re.compile(r"frames/\d{6}\.\w+")
"""A picture of a recording that is a folder."""
MOST_LISTED = 3
"""Most files of others that a message names."""


def register(app: typer.Typer) -> None:
    """Add the command `record` to the application."""
    app.command("record")(record)


def record(
    scenario: str = typer.Argument(
        ...,
        help="A scenario file, or a bundled scenario: concealed, demo, develop, paper, split_small, tiny.",
    ),
    out: Path = typer.Option(..., "--out", help="Folder for the logs; it is made where it is missing."),
    form: str = typer.Option("mcap", "--format", help="Form of the logs: mcap or folder."),
    workers: int = WORKERS,
    as_json: bool = JSON_OPTION,
) -> None:
    """Make simulated recordings of a world with known truth.

    The recordings are ordinary logs of a UR5e that presses DIGIT sensors.

    Example: tactiledata record demo --out recordings --format mcap
    """
    from tactiledata.contract.simulated import SimulatedCount
    from tactiledata.rig.record import TRUTH, log_groups
    from tactiledata.rig.record import record as play
    from tactiledata.rig.scenario.scenario import load_scenario
    from tactiledata.rig.scenario.worlds import find_scenario

    with wrong_document_is_wrong_usage():
        loaded = load_scenario(find_scenario(scenario))
    need_workers(workers)
    need_writable_folder(out)
    need_writable_folder(out / TRUTH)
    for name, _ in log_groups(loaded):
        if form == "mcap":
            refuse_foreign(out / f"{name}.mcap")
        else:
            _refuse_foreign_folder(out / name)
        for ending, mark in TRUTH_MARKS.items():
            refuse_foreign(out / TRUTH / f"{name}{ending}", mark)
    with progress("recording", quiet=as_json) as report_progress:
        try:
            logs = play(loaded, out, cast("Form", form), report_progress, workers)
        except TactileDataError as error:
            raise _in_usual_words(error, out) from error
    if as_json:
        simulated = SimulatedCount(simulated=len(logs)).document()
        emit({"logs": [str(log) for log in logs], "truth": str(out / "truth"), "simulated_recordings": simulated})
        return
    for log in logs:
        say(str(log))
    say(
        f"{counted(len(logs), 'log')} of simulated recordings in {out}; the truth is in {out / 'truth'}, "
        "which the toolkit never reads"
    )


def _refuse_foreign_folder(folder: Path) -> None:
    """Refuse a folder in the place of a recording that holds what the recorder does not write: it would be lost."""
    from tactiledata.contract.schema import read_document
    from tactiledata.rig.logs.write_folder import FILES

    refuse_foreign(folder)
    if folder.is_symlink():
        raise UsageError(
            f"the recording {folder} is a link to {folder.readlink()}",
            "a place where nothing is, or a recording as the recorder wrote it",
            "Remove the link, or name another place with --out.",
        )
    if not (folder / LOG).is_file():
        return
    with wrong_document_is_wrong_usage():
        named = _texts(read_document(folder / LOG, "log"))
    written = {LOG, "trajectories.csv", "frames.csv", *FILES.values(), *named}
    paths = [path for path in sorted(folder.rglob("*")) if path.is_symlink() or not path.is_dir()]
    others = [str(name) for path in paths if (name := path.relative_to(folder).as_posix()) not in written]
    if others := [name for name in others if not PICTURE.fullmatch(name)]:
        more = "" if len(others) <= MOST_LISTED else f" and {len(others) - MOST_LISTED} more"
        raise UsageError(
            f"the recording {folder} holds {', '.join(others[:MOST_LISTED])}{more}, which the recorder did not write",
            "a place where nothing is, or a recording as the recorder wrote it",
            "Move these files, or name another place with --out.",
        )


def _texts(document: Any) -> Iterator[str]:
    """All texts in a document: those that name files are among them."""
    if isinstance(document, str):
        yield document
    elif isinstance(document, dict | list):
        for part in document.values() if isinstance(document, dict) else document:
            yield from _texts(part)


def _in_usual_words(error: TactileDataError, out: Path) -> TactileDataError:
    """Return the error of a folder that cannot be written to in the words of all commands; any other as it is."""
    cause = error.__cause__
    if not isinstance(cause, OSError) or cause.errno not in (*FULL, *REFUSED):
        return error
    found, expected, remedy = refusal(cause, cause.filename or out)
    return TactileDataError(found, expected, f"{remedy} Logs that are already there are whole.", **error.facts)
