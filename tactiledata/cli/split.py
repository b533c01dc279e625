"""`split` and `audit`: who may learn from what, and whether anything leaks."""

from __future__ import annotations

import dataclasses
import shlex

import typer

from tactiledata.cli.explain import damage_explains
from tactiledata.cli.output import JSON_OPTION, emit, findings, progress, say, table
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    app.command("split")(split)
    app.command("audit")(audit)


def split(
    store: str = STORE_ARGUMENT,
    by: str = typer.Option(
        "trajectory,sensor", "--by", help="trajectory, and the units to count by and to hold out: sensor, indenter."
    ),
    hold_out: str = typer.Option(
        "auto", "--hold-out", help="sensor=…,indenter=… kept for the second test; auto, or none."
    ),
    fractions: str = typer.Option("0.8,0.1,0.1", "--fractions", help="Shares of train, val and test."),
    force: str = typer.Option("1..13", "--force", help="Contact force in newtons that a frame must have, or none."),
    seed: int = typer.Option(0, "--seed", help="Another seed draws another split."),
    name: str = typer.Option("default", "--name", help="Name of the split inside the store."),
    replace: bool = typer.Option(False, "--replace", help="Draw it anew where one of that name has other options."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Deal out whole trajectories to train, val, test, test_unseen. The last holds sensors and indenters held out.

    Example: tactiledata split --by trajectory,sensor
    """
    from tactiledata.splits.make import make_split
    from tactiledata.store.read.reader import Store

    location = working_store(store)
    with damage_explains(location):
        opened = Store.open(location)
        report = make_split(opened, name, by, hold_out, fractions, force, seed, replace)
    if as_json:
        emit(report.document())
        return
    rows = [(part, count.trajectories, count.frames) for part, count in report.counts.items()]
    table(f"split {report.name!r} of {opened.location}", ("part", "trajectories", "frames"), rows)
    for kind, names in report.held_out.items():
        say(f"held out for test_unseen: {kind} {', '.join(names)}")
    for note in report.notes:
        say(f"note: {note}")
    say(f"next: {shlex.join(['tactiledata', 'audit', opened.location, '--split', report.name])}")


def audit(
    store: str = STORE_ARGUMENT,
    split: str = typer.Option("default", "--split", help="Name of the split."),
    images: bool = typer.Option(True, "--images/--no-images", help="Look for near copies among the images, too."),
    parents: str = typer.Option(
        None, "--parents", help="The store that this one's trajectories were derived from: their parts are compared."
    ),
    as_json: bool = JSON_OPTION,
) -> None:
    """Look for leaks between the parts of a split. Exit 1 where there is one.

    Example: tactiledata audit --split default
    """
    from tactiledata.splits.across import audit_across
    from tactiledata.splits.audit import audit as look
    from tactiledata.store.read.reader import Store

    location = working_store(store)
    with damage_explains(location), progress("auditing", quiet=as_json) as tell:
        opened = Store.open(location)
        report = look(opened, split, images, tell)
        if parents is not None:
            across = audit_across(opened, Store.open(parents), split)
            report = dataclasses.replace(report, findings=(*report.findings, *across))
    if as_json:
        emit(report.document())
    else:
        findings((split, finding) for finding in report.findings)
        say(report.lines()[0])
    if report.leaks:
        raise typer.Exit(1)
