"""`split` and `audit`: parts of a store for training and testing, and a search for leaks between them."""

from __future__ import annotations

import dataclasses
import shlex

import typer

from tactiledata.cli.explain import damage_explains
from tactiledata.cli.given_values import need_seed
from tactiledata.cli.output import JSON_OPTION, emit, findings, progress, say, table
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store
from tactiledata.contract.wording import listed

OF_COPIES = {"identical-image", "near-duplicate-image"}
"""Leaks by images of recordings that are copies of one another."""
MOST_COPIES = 4
"""Recordings that a note on copies names."""


def register(app: typer.Typer) -> None:
    """Add the commands `split` and `audit` to the application."""
    app.command("split")(split)
    app.command("audit")(audit)


def split(
    store: str = STORE_ARGUMENT,
    by: str = typer.Option(
        "trajectory,sensor",
        "--by",
        help="Units of the split: trajectory, and those to count by and to hold out (sensor, indenter).",
    ),
    hold_out: str = typer.Option(
        "auto", "--hold-out", help="Units of test_unseen: sensor=…,indenter=…, or auto, or none."
    ),
    fractions: str = typer.Option("0.8,0.1,0.1", "--fractions", help="Shares of train, val and test."),
    force: str = typer.Option("1..13", "--force", help="Range of contact force of the frames, in newtons, or none."),
    seed: int = typer.Option(0, "--seed", help="Random seed for drawing the split."),
    name: str = typer.Option("default", "--name", help="Name of the split inside the store."),
    replace: bool = typer.Option(False, "--replace", help="Replace a split of this name that has other options."),
    with_flagged: bool = typer.Option(
        False, "--with-flagged", help="Take trajectories that are flagged as bad, too; they are left out by default."
    ),
    as_json: bool = JSON_OPTION,
) -> None:
    """Divide whole trajectories into train, val, test, test_unseen.

    The part test_unseen has the sensors and indenters that are held out.

    Example: tactiledata split --by trajectory,sensor
    """
    from tactiledata.ingest.checks.twins import twins_of_store
    from tactiledata.splits.make import make_split
    from tactiledata.store.read.reader import Store
    from tactiledata.store.read.recording_names import recording_names

    need_seed(seed)
    location = working_store(store)
    with damage_explains(location):
        opened = Store.open(location)
        report = make_split(
            opened, name, by, hold_out, fractions, force, seed, replace=replace, with_flagged=with_flagged
        )
        keys = recording_names(opened)
        copies = [keys[row] for row in twins_of_store(opened)]
    if as_json:
        emit({**report.document(), "copies": copies})
        return
    rows = [(part, count.trajectories, count.frames) for part, count in report.counts.items()]
    table(f"split {report.name!r} of {opened.location}", ("part", "trajectories", "frames"), rows)
    for kind, names in report.held_out.items():
        say(f"held out for test_unseen: {kind} {', '.join(names)}")
    for note in report.notes:
        say(f"note: {note}")
    if copies:
        shared = f"recordings that hold touches of each other: {listed(copies, MOST_COPIES)}"
        say(f"note: {shared}. {_flag_them(opened.location)}")
    say(f"next: {shlex.join(['tactiledata', 'audit', opened.location, '--split', report.name])}")


def _flag_them(location: str) -> str:
    """Say where a person finds the command that flags copies."""
    shown = shlex.join(["tactiledata", "info", location])
    return f"`{shown}` names the recordings that are copies, and the command that flags them"


def audit(
    store: str = STORE_ARGUMENT,
    split: str = typer.Option("default", "--split", help="Name of the split."),
    images: bool = typer.Option(True, "--images/--no-images", help="Also look for near copies among the images."),
    parents: str = typer.Option(
        None,
        "--parents",
        help="Store that the trajectories of this store were derived from; the parts of both are compared.",
    ),
    as_json: bool = JSON_OPTION,
) -> None:
    """Look for leaks between the parts of a split.

    The exit code is 1 where there is a leak.

    Example: tactiledata audit --split default
    """
    from tactiledata.splits.across import audit_across
    from tactiledata.splits.audit import audit as look
    from tactiledata.store.read.reader import Store

    location = working_store(store)
    with damage_explains(location), progress("auditing", quiet=as_json) as report_progress:
        opened, other = Store.open(location), None if parents is None else Store.open(parents)
        report = look(opened, split, images, report_progress)
        if other is not None:
            across = audit_across(opened, other, split)
            report = dataclasses.replace(report, findings=(*report.findings, *across))
    if as_json:
        emit(report.document())
    else:
        findings((split, finding) for finding in report.findings)
        say(report.lines()[0])
        if {finding.code for finding in report.leaks} & OF_COPIES:
            say(f"copies of images: {_flag_them(opened.location)}")
    if report.leaks:
        raise typer.Exit(1)
