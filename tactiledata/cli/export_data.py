"""The command `export-data`: a store in the formats that others train from or look at."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from tactiledata.cli.explain import damage_explains
from tactiledata.cli.output import JSON_OPTION, emit, progress, say, table
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store
from tactiledata.contract.simulated import SimulatedCount
from tactiledata.contract.wording import counted
from tactiledata.export import EXPORTERS
from tactiledata.splits.options import PARTITIONS

if TYPE_CHECKING:
    from tactiledata.export.export import ExportReport


def register(app: typer.Typer) -> None:
    """Add the command `export-data` to the application."""
    app.command("export-data")(export_data)


def export_data(
    store: str = STORE_ARGUMENT,
    to: str = typer.Option(..., "--to", help=f"Format: {', '.join(EXPORTERS)}."),
    out: Path = typer.Option(None, "--out", help="New folder [default: the store's name and the format]."),
    split: str = typer.Option(
        None, "--split", help="Split that gives the parts, or none [default: default, where there is one]."
    ),
    camera: str = typer.Option(None, "--camera", help="Camera, where the store has several."),
    streams: str = typer.Option(None, "--streams", help="Values at the frames, with commas [default: all]."),
    action: str = typer.Option(
        None, "--action", help="Stream whose next value is the action, or none [default: tcp, where there is one]."
    ),
    file_mb: int = typer.Option(100, "--file-mb", help="Size at which a file ends and the next begins, in 10^6 bytes."),
    replace: bool = typer.Option(False, "--replace", help="Replace another export at that place."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Write the recordings of a store in another format.

    Splits, units, frames, signs and provenance travel along. What is lost is said.

    Example: tactiledata export-data ds.zarr --to lerobot --out for-lerobot
    """
    from tactiledata.export.export import export_data as write
    from tactiledata.export.plan import ExportPlan
    from tactiledata.loaders.selection import FlaggedTrajectoriesWarning
    from tactiledata.store.read.reader import Store

    location = working_store(store)
    EXPORTERS[to]
    chosen = None if streams is None else tuple(name.strip() for name in streams.split(",") if name.strip())
    plan = ExportPlan(to, split or "", camera or "", chosen, action or "", file_mb)
    place = out if out is not None else Path(f"{Path(location.rstrip('/')).stem}-{to}")
    # a rename ends the export: it would take the place of a link, and not of the folder behind it
    place = place.resolve() if place.is_symlink() else place
    with (
        damage_explains(location),
        progress(f"exporting to {to}", quiet=as_json) as report_progress,
        warnings.catch_warnings(),
    ):
        # the export's remarks say the same
        warnings.simplefilter("ignore", FlaggedTrajectoriesWarning)
        report = write(Store.open(location), plan, place, replace, report_progress)
    if as_json:
        emit({"folder": str(report.folder), "was_there": report.was_there, **report.document})
        return
    _say(report)


def _say(report: ExportReport) -> None:
    """Print what an export holds, what was lost, and where to read on."""
    document = report.document
    if sentence := SimulatedCount(**document["simulated_recordings"]).sentence:
        say(sentence)
    parts = sorted(document["parts"].items(), key=lambda one: (*PARTITIONS, one[0]).index(one[0]))
    rows = [(part, each["trajectories"], each["frames"], each["in_split"]) for part, each in parts]
    table(f"{report.folder}", ("part", "trajectories", "frames", "in the split"), rows)
    for sentence in document["remarks"]:
        say(f"note: {sentence}")
    for reason, count in document["left_out"].items():
        say(f"left out: {counted(count, 'frame')} {reason}")
    for sentence in document["lost"]:
        say(f"lost: {sentence}")
    size = sum(facts["bytes"] for facts in document["files"].values())
    before = "it was there already: " if report.was_there else ""
    say(f"{before}{counted(len(document['files']), 'file')}, {size / 1e6:.1f} MB in {report.folder}")
    say(f"how to load it: {report.folder / 'README.md'}")
