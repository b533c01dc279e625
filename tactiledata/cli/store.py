"""`info`, `check`, `merge`, `report`: the content of a store, and whether it is whole."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import typer

from tactiledata.cli.documents import refuse_result_of_another_store
from tactiledata.cli.explain import damage_explains
from tactiledata.cli.given_values import need_writable_folder
from tactiledata.cli.next_steps import next_steps
from tactiledata.cli.output import JSON_OPTION, emit, findings, progress, say, table
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store
from tactiledata.contract.extras import PAGE, need_packages
from tactiledata.contract.wording import counted, listed
from tactiledata.errors import UnknownName

MOST_NAMED = 4
"""Recordings that `info` names of each camera."""
MOST_FLAGS = 20
"""Flagged trajectories that `info` lists."""


def register(app: typer.Typer) -> None:
    """Add the commands `info`, `check`, `merge` and `report` to the application."""
    app.command("info")(info)
    app.command("check")(check)
    app.command("merge")(merge)
    app.command("report")(report)


def info(
    store: str = STORE_ARGUMENT,
    trajectories: bool = typer.Option(False, "--trajectories", help="List every trajectory by its name, too."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Show what a store holds, and what comes next.

    Example: tactiledata info ds.zarr
    """
    from tactiledata.formats.mcap.passed_over import TOPIC_LEFT
    from tactiledata.ingest.checks.beside import findings_beside
    from tactiledata.store.read.overview import found_in, listed_trajectories, overview, shown_rate
    from tactiledata.store.read.reader import Store
    from tactiledata.store.read.recording_names import recording_names
    from tactiledata.store.read.simulated import simulated_recordings

    location = working_store(store)
    with damage_explains(location):
        opened = Store.open(location)
        beside = findings_beside(opened)
        facts = overview(opened, beside)
        told = found_in(opened, beside) if as_json else []
        touches = listed_trajectories(opened) if trajectories else []
    if as_json:
        emit({**facts, "all_findings": told, **({"trajectory_list": touches} if trajectories else {})})
        return
    # recordings, cameras, sensors, indenters and signals
    say(
        f"{opened.location}: {counted(facts['sources'], 'recording')}, "
        f"{counted(facts['trajectories'], 'trajectory')}, {counted(facts['frames'], 'image')}"
    )
    if sentence := simulated_recordings(opened).sentence:
        say(sentence)
    cameras = [(name, row["frames"], listed(row["recordings"], MOST_NAMED)) for name, row in facts["by_camera"].items()]
    if cameras:
        table("", ("camera", "images", "recordings"), cameras)
    sensors = [
        (name, row["model"] or "-", row["trajectories"], row["frames"]) for name, row in facts["by_sensor"].items()
    ]
    if sensors:
        table("", ("sensor", "model", "trajectories", "images"), sensors)
    idle = [name for name, row in facts["by_sensor"].items() if not row["trajectories"] and not row["frames"]]
    if idle:
        say(f"without a trajectory or an image, so that no split holds it: {', '.join(idle)}")
    pressed = [
        (name or "(not named)", row["trajectories"], row["frames"]) for name, row in facts["by_indenter"].items()
    ]
    if pressed:
        table("", ("indenter", "trajectories", "images"), pressed)
    signals = [
        (
            name,
            " ".join(row["columns"]),
            row["frame"] or "-",
            row["samples"],
            shown_rate(row["rate_hz"]),
            shown_rate(row["effective_rate_hz"]),
        )
        for name, row in facts["signals"].items()
    ]
    if signals:
        table("", ("signal", "columns", "frame", "samples", "Hz", "changes at Hz while moving"), signals)
    if touches:
        table(
            "",
            ("trajectory", "sensor", "indenter", "images", "s", "peak N", "flagged as bad"),
            map(_touch_row, touches),
        )
    # splits, meshes, flags and findings
    for name in opened.split_names():
        say(f"split: {name}")
    for name, mesh in facts["meshes"].items():
        have = ", ".join(f"{count} {words}" for words, count in mesh["status"].items())
        effects = f", with {', '.join(mesh['effects'])}" if mesh["effects"] else ""
        say(f"mesh: {name}, {mesh['fidelity']}{effects}, {mesh['vertices']} vertices ({mesh['kept']} kept): {have}")
    for line in _flag_lines(opened.location, facts["flagged"]):
        say(line)
    if facts["status"]:
        statuses = ", ".join(f"{count} {status}" for status, count in sorted(facts["status"].items()))
        left = facts["findings"].get(TOPIC_LEFT, {"sources": 0})["sources"]
        say(f"status: {statuses}{f'; of {left} of them a wrench, tcp or images are not read' if left else ''}")
    for code, row in sorted(facts["findings"].items()):
        say(f"  {row['severity']:<7} {code}: {row['count']} in {counted(row['sources'], 'recording')}")
    keys = recording_names(opened)
    findings((keys[row], finding) for row, found in beside.items() for finding in found)
    say(f"digest: {opened.digest}")
    with damage_explains(location):
        for line in next_steps(opened):
            say(line)


def _touch_row(touch: Mapping[str, Any]) -> tuple[Any, ...]:
    """Return the cells of a trajectory in the list of `info`."""
    peak = "-" if touch["peak_force"] is None else f"{touch['peak_force']:.2f}"
    named = (touch[name] or "-" for name in ("sensor", "indenter"))
    return touch["name"], *named, touch["images"], f"{touch['seconds']:.1f}", peak, touch["flag"]


def _flag_lines(location: str, flags: list[dict[str, str]]) -> list[str]:
    """Return what `info` says of flagged trajectories; nothing where there are none."""
    if not flags:
        return []
    lines = [f"flagged as bad, and left out of splits: {counted(len(flags), 'trajectory')}"]
    lines += [f"  {flag['name']}: {flag['reason']}" for flag in flags[:MOST_FLAGS]]
    if len(flags) > MOST_FLAGS:
        lines.append(f"  and {len(flags) - MOST_FLAGS} more: {shlex.join(['tactiledata', 'flag', location, '--list'])}")
    return lines


def check(
    store: str = STORE_ARGUMENT,
    repair: bool = typer.Option(False, "--repair", help="Repair damage that can be repaired without inventing data."),
    decode: bool = typer.Option(
        False,
        "--decode",
        help="Also decode every image: slow, and finds damage from before ingest; in a JPEG, only a part of it.",
    ),
    as_json: bool = JSON_OPTION,
) -> None:
    """Check every byte of a store against its checksums.

    The tables are also compared with each other. The exit code is 1 on damage.

    Example: tactiledata check ds.zarr --repair
    """
    from tactiledata.store.check.check import check as look
    from tactiledata.store.check.repair import repair as mend

    location = working_store(store)
    with damage_explains(location), progress("checking", quiet=as_json) as report_progress:
        if repair:
            results = mend(location, decode, report_progress)
        else:
            results = look(location, decode=decode, progress=report_progress)
    mended = [finding for finding in results if finding.code == "store-mended"]
    remaining = [finding for finding in results if finding.code != "store-mended"]
    if as_json:
        emit({"mended": [vars(finding) for finding in mended], "findings": [vars(finding) for finding in remaining]})
    else:
        findings(("mended", finding) for finding in mended)
        findings(("", finding) for finding in remaining)
        say("the store is whole" if not remaining else counted(len(remaining), "finding"))
    if any(finding.severity == "damage" for finding in remaining):
        raise typer.Exit(1)


def merge(
    stores: list[str] = typer.Argument(..., help="Stores to copy from; they stay unchanged."),
    into: Path = typer.Option(..., "--into", help="Store to add to; it is made where it is missing."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Add the recordings of several stores to one.

    A recording that several stores hold is added once. Splits are not copied.

    Example: tactiledata merge monday.zarr tuesday.zarr --into week.zarr
    """
    from tactiledata.store.change.merge import merge as add

    with progress("merging", quiet=as_json) as report_progress:
        merged = add(stores, into, report_progress)
    if as_json:
        emit({"store": str(into), "findings": [vars(finding) for finding in merged]})
        return
    findings(("", finding) for finding in merged)
    say(f"merged into {into}")


def report(
    store: str = STORE_ARGUMENT,
    out: Path = typer.Option(Path("report"), "--out", help="Folder for report.html and recorded.png."),
    split: str = typer.Option(None, "--split", help="Split to describe [default: default, where there is one]."),
    replace: bool = typer.Option(False, "--replace", help="Replace a page about another store, too."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Write a page about a store, with pictures.

    The page shows what was recorded, what was wrong with it, and what the parts of a split hold.

    Example: tactiledata report ds.zarr --out report
    """
    need_packages("a page", *PAGE)
    need_writable_folder(out, "report.html", "recorded.png")
    from tactiledata.ingest.sources.overview import write_report
    from tactiledata.replay.overview import mesh_sections
    from tactiledata.store.read.reader import Store
    from tactiledata.store.read.simulated import simulated_recordings

    location = working_store(store)
    with damage_explains(location):
        opened = Store.open(location)
        if split is not None and split not in opened.split_names():
            raise UnknownName("split", split, opened.split_names(), "`tactiledata split` makes a split.")
        refuse_result_of_another_store(out / "report.html", opened, replace)
        written = write_report(opened, out, split or "default", mesh_sections(opened))
    simulated = simulated_recordings(opened)
    if as_json:
        emit({**{name: str(path) for name, path in written.items()}, "simulated_recordings": simulated.document()})
        return
    if simulated.sentence:
        say(simulated.sentence)
    for path in written.values():
        say(str(path))
