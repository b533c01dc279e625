"""`flag`: trajectories of a store that are bad, so that splits leave them out."""

from __future__ import annotations

import shlex

import typer

from tactiledata.cli.explain import damage_explains
from tactiledata.cli.output import JSON_OPTION, emit, say, table
from tactiledata.cli.working_store import store_and_names
from tactiledata.contract.wording import counted
from tactiledata.errors import UsageError


def register(app: typer.Typer) -> None:
    """Add the command `flag` to the application."""
    app.command("flag")(flag)


def flag(
    words: list[str] = typer.Argument(
        None,
        metavar="[STORE] TRAJECTORY...",
        help="A store (default: the only store in the working folder), and trajectories: uid, name, or recording/name.",
    ),
    reason: str = typer.Option(None, "--reason", help="What is wrong with the trajectories, in a sentence."),
    remove: bool = typer.Option(False, "--remove", help="Take the flags of the trajectories off."),
    show: bool = typer.Option(False, "--list", help="List the flagged trajectories."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Flag trajectories as bad.

    Splits leave flagged trajectories out, and what was derived from them; nothing is deleted.
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
        raise UsageError("no trajectory is named", "a uid, a name, or recording/name", "`tactiledata flag --help`")
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
    from tactiledata.store.read.reader import Store

    if reason is None:
        changed, done = remove_flags(location, names), "no longer flagged"
    else:
        changed, done = flag_trajectories(location, names, reason), "flagged"
    if as_json:
        emit({"store": location, "changed": changed, "state": done, "flagged": _flagged(location)})
        return
    for name in changed:
        say(f"{done}: {name}")
    if not changed:
        say("nothing to change: flagged already, with this reason")
    store = Store.open(location)
    if store.split_names():
        for line in next_steps(store):
            say(line)


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
