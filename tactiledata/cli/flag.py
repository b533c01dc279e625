"""`flag`: trajectories of a store that are bad, so that splits leave them out."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from typing import TYPE_CHECKING

import typer

from tactiledata.cli.explain import damage_explains
from tactiledata.cli.output import JSON_OPTION, emit, say, table
from tactiledata.cli.working_store import store_and_names
from tactiledata.contract.wording import counted, listed
from tactiledata.errors import UnknownName, UsageError

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

MOST_COPIES = 4
"""Copies in other recordings that are named in a sentence."""


def register(app: typer.Typer) -> None:
    """Add the command `flag` to the application."""
    app.command("flag")(flag)


def flag(
    words: list[str] = typer.Argument(
        None,
        metavar="[STORE] TRAJECTORY...",
        help="A store (default: the only store in the working folder), and trajectories: uid, name, or "
        "recording/name; a recording for all its trajectories.",
    ),
    reason: str = typer.Option(None, "--reason", help="What is wrong with the trajectories, in a sentence."),
    remove: bool = typer.Option(False, "--remove", help="Take the flags of the trajectories off."),
    show: bool = typer.Option(False, "--list", help="List the flagged trajectories."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Flag trajectories as bad.

    Splits leave flagged trajectories out, and what was derived from them; nothing is deleted.
    Of a recording that is named alone, all trajectories are flagged. Copies in other recordings are named.
    Look at trajectories with `tactiledata view`.

    Example: tactiledata flag ds.zarr D20001.mcap/t00000 --reason "the gel slipped off its mount"
    """
    location, names = store_and_names(words)
    if show + remove + (reason is not None) != 1:
        raise UsageError(
            f"flag with {', '.join(_given(reason, remove, show)) or 'no option'}",
            "one of --reason TEXT, --remove, --list",
            "For example: tactiledata flag ds.zarr t00000 --reason 'the sensor was unplugged'.",
        )
    if show:
        if names:
            raise UsageError(f"--list with {names[0]}", "no trajectory", "Leave the trajectory out.")
        with damage_explains(location):
            _list(location, as_json)
        return
    if not names:
        raise UsageError(
            "no trajectory is named", "a uid, a name, recording/name, or a recording", "`tactiledata flag --help`"
        )
    if "://" in location or "::" in location:
        raise UsageError(
            f"the store {location} is not on a local disk", "a local store", "Flag it on the machine that holds it."
        )
    with damage_explains(location):
        _change(location, names, reason, as_json)


def _given(reason: str | None, remove: bool, show: bool) -> list[str]:
    options = {"--reason": reason is not None, "--remove": remove, "--list": show}
    return [option for option, is_given in options.items() if is_given]


def _change(location: str, names: list[str], reason: str | None, as_json: bool) -> None:
    """Flag trajectories where there is a reason, else take their flags off; say what changed, and what comes next."""
    from tactiledata.cli.next_steps import next_steps
    from tactiledata.store.change.flag import flag_trajectories, remove_flags
    from tactiledata.store.read.flags import flagged_trajectories, is_of_copy
    from tactiledata.store.read.reader import Store

    opened = Store.open(location)
    rows, before = _copies(opened, names), {flag.name: flag.reason for flag in flagged_trajectories(opened).values()}
    if reason is None:
        changed, done = remove_flags(location, names), "no longer flagged"
    else:
        changed, done = flag_trajectories(location, names, reason), "flagged"
    store = Store.open(location)
    copies = _named_unlike(store, rows, is_flagged=reason is not None)
    if as_json:
        emit({"store": location, "changed": changed, "state": done, "flagged": _flagged(location), "copies": copies})
        return
    for name in changed:
        replaced = f" (before: {before[name]})" if reason is not None and name in before else ""
        say(f"{done}: {name}{replaced}")
    if not changed:
        say("nothing to change: flagged already")
    if copies:
        option = ["--remove"] if reason is None else ["--reason", reason]
        state, wish = ("stay flagged", "take these flags off") if reason is None else ("stay in splits", "flag these")
        say(f"the same touches are in other recordings, and {state} there: {listed(copies, MOST_COPIES)}")
        # of a recording that was left out as a copy, the other one is wanted
        if reason is None or (_are_touches(store, names) and not is_of_copy(reason)):
            say(f"to {wish}, too: {shlex.join(['tactiledata', 'flag', location, *copies, *option])}")
    if store.split_names():
        for line in next_steps(store):
            say(line)


def _copies(store: Store, names: Sequence[str]) -> list[int]:
    """Return the rows of the trajectories that are copies, in other recordings, of those that are named."""
    from tactiledata.ingest.checks.twins import twin_rows
    from tactiledata.store.read.flags import stored_flags
    from tactiledata.store.read.named_trajectories import named_trajectories

    gone = set(stored_flags(store)) - set(store.trajectories(["uid"])["uid"].to_pylist())
    there = [name for name in names if name not in gone]
    return twin_rows(store, named_trajectories(store, there, whole_recordings=True))


def _are_touches(store: Store, names: Sequence[str]) -> bool:
    """Whether each name is that of a trajectory, and none that of a recording."""
    from tactiledata.store.read.named_trajectories import named_trajectories

    try:
        named_trajectories(store, names)
    except UnknownName:
        return False
    return True


def _named_unlike(store: Store, rows: Sequence[int], is_flagged: bool) -> list[str]:
    """Return the full names of the trajectories that are not flagged, or those that are."""
    from tactiledata.store.read.flags import flagged_trajectories
    from tactiledata.store.read.named_trajectories import full_names

    uids, full, flagged = store.trajectories(["uid"])["uid"].to_pylist(), full_names(store), flagged_trajectories(store)
    return [full[row] for row in rows if (uids[row] in flagged) != is_flagged]


def _flagged(location: str) -> list[dict[str, str]]:
    from tactiledata.store.read.flags import flagged_trajectories
    from tactiledata.store.read.reader import Store

    return [flag.document() for flag in flagged_trajectories(Store.open(location)).values()]


def _list(location: str, as_json: bool) -> None:
    """Print the flagged trajectories, and the flags of trajectories that the store does not hold."""
    from tactiledata.store.read.flags import stored_flags
    from tactiledata.store.read.reader import Store

    flagged = _flagged(location)
    used = {flag["origin"] for flag in flagged}
    elsewhere = [
        {"uid": uid, "name": f"{entry['recording']}/{entry['trajectory']}", "reason": entry["reason"]}
        for uid, entry in stored_flags(Store.open(location)).items()
        if uid not in used
    ]
    if as_json:
        emit({"store": location, "flagged": flagged, "not_in_store": elsewhere})
        return
    say(f"{location}: {counted(len(flagged), 'flagged trajectory')}")
    rows = [
        (flag["name"], flag["uid"], flag["reason"], "" if flag["origin"] == flag["uid"] else flag["origin"])
        for flag in flagged
    ]
    if rows:
        table("", ("trajectory", "uid", "reason", "derived from the flagged"), rows)
    for flag in elsewhere:
        say(f"not in this store (any more): {flag['name']}, {flag['uid']}: {flag['reason']}")
    if elsewhere:
        say(f"to forget one: {shlex.join(['tactiledata', 'flag', location, elsewhere[0]['uid'], '--remove'])}")
