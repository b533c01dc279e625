"""`ingest`: add recordings to a store."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import typer

from tactiledata.cli.documents import mapping_document
from tactiledata.cli.given_values import need_local_place
from tactiledata.cli.next_steps import next_steps
from tactiledata.cli.output import JSON_OPTION, emit, findings, progress, say, say_left_alone, table
from tactiledata.cli.task_options import SCHEDULER, WORKERS
from tactiledata.contract.wording import counted
from tactiledata.errors import UsageError


def register(app: typer.Typer) -> None:
    """Add the command `ingest` to the application."""
    app.command("ingest")(ingest)


def ingest(
    paths: list[Path] = typer.Argument(..., help="Recordings, or folders of recordings."),
    store: str = typer.Option(None, "--store", help="Store to add to [default: the only *.zarr here, else ds.zarr]."),
    mapping: Path = typer.Option(
        None, "--mapping", help="File that states the meaning of each topic (schemas/mapping.json)."
    ),
    format_name: str = typer.Option(None, "--format", help="Read the recordings as this format, without detection."),
    replace: bool = typer.Option(
        False, "--replace", help="Read recordings of the store again; a corrected recording replaces the old one."
    ),
    strict: bool = typer.Option(False, "--strict", help="Refuse a recording with any damage."),
    gap_limit: float = typer.Option(
        0.1, "--gap-limit", help="Longest gap around a frame, in seconds; a longer one flags the frame."
    ),
    workers: int = WORKERS,
    scheduler: str = SCHEDULER,
    as_json: bool = JSON_OPTION,
) -> None:
    """Add recordings to a store; those it has stay unchanged. Safe to kill and to run again.

    Example: tactiledata ingest recordings --store ds.zarr --workers 2

    After log.yaml or a mapping was corrected: tactiledata ingest recordings/run7 --store ds.zarr --replace
    """
    from tactiledata.ingest.pipeline import ingest as add
    from tactiledata.ingest.trajectories.assemble import IngestOptions

    if not 0 < gap_limit < 1e6:
        raise UsageError(f"--gap-limit {gap_limit}", "a number of seconds above 0")
    options = IngestOptions(
        mapping=mapping_document(mapping),
        format_name=format_name,
        strict=strict,
        gap_limit_ns=round(gap_limit * 1e9),
    )
    target = store or _store_here()
    need_local_place(target, "--store")
    with progress("ingesting", quiet=as_json) as report_progress:
        report = add(paths, target, options, workers, scheduler, report_progress, replace)
    if as_json:
        emit(report.document())
    else:
        _print(report)
    if report.fell_short:
        raise typer.Exit(1)


def _store_here() -> str:
    """Return the only store of the working folder, else ``ds.zarr``; refuse a folder of several stores."""
    stores = sorted(path.name for path in Path.cwd().glob("*.zarr") if path.is_dir())
    if len(stores) > 1:
        raise UsageError(f"the working folder holds several stores: {', '.join(stores)}", "one", "Name it: --store S")
    return stores[0] if stores else "ds.zarr"


def _print(report: Any) -> None:
    """Print what was done with each recording, the findings, the counts and the next step."""
    from tactiledata.ingest.sources.reports import status_in_words

    words = {"added": "added", "replaced": "replaced", "present": "already there", "failed": "not read"}
    rows = [
        (
            source.words,
            f"a copy of {source.copy_of}" if source.copy_of else words[source.state],
            status_in_words(source.status, source.findings) or "-",
            source.trajectories,
            source.frames,
        )
        for source in report.sources
    ]
    table("", ("recording", "what was done", "status", "trajectories", "frames"), rows)
    findings(
        [
            *((source.name or source.key, finding) for source in report.sources for finding in source.findings),
            *(("", finding) for finding in report.findings),
        ],
        all_of_them=f"--json; those that were kept: {shlex.join(['tactiledata', 'info', str(report.store), '--json'])}",
    )
    for source in report.sources:
        if source.error:
            say(f"  not read {source.words}: {source.error}")
    # files that are no recordings
    say_left_alone(report.unclaimed)
    # counts, and what to do next
    counts = {state: sum(source.state == state for source in report.sources) for state in ("added", "replaced")}
    replaced = f", {counts['replaced']} replaced in it" if counts["replaced"] else ""
    added = counted(counts["added"], "recording") if report.changed or not report.fell_short else "no recording was"
    say(f"{added} added to {report.store}{replaced}")
    if report.simulated.sentence:
        say(report.simulated.sentence)
    if report.changed:
        from tactiledata.store.read.reader import Store

        if counts["replaced"] and report.stale_splits:
            say("note: a split draws a replaced recording as a new one: its touches may come into another part")
        for line in next_steps(Store.open(report.store)):
            say(line)
