"""What to do next with a store, as a command that runs: split it, bring its split up to date, or audit the split."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING

from tactiledata.contract.wording import agreeing, counted
from tactiledata.errors import LeakError, TactileDataError

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store


def next_steps(store: Store) -> list[str]:
    """Return the lines that say what comes next for a store: none where it lies behind an address."""
    from tactiledata.splits.flagged import flagged_in_parts
    from tactiledata.splits.manifest import load_split

    if "://" in store.location:
        return []
    names = store.split_names()
    if not names:
        return [first_split(store)]
    lines = []
    for name in names:
        try:
            held = flagged_in_parts(store, load_split(store, name))
        except LeakError:
            lines.append(stale_split(store, name))
        except TactileDataError:
            lines.append(f"the split {name} is damaged; draw it again: {_drawn_again(store, name)}")
        else:
            if held:
                lines.append(flagged_split(store, name, len(held)))
                continue
            lines += current_split(store, name)
    return lines


def first_split(store: Store) -> str:
    """Return the command that splits a store, or the reason why it cannot be split yet."""
    from tactiledata.splits.suggest import suggest_split

    suggested = suggest_split(store)
    return f"next: {suggested.command}" if suggested.command else f"no split can be drawn yet: {suggested.reason}"


def current_split(store: Store, name: str) -> list[str]:
    """Say what comes next for a split that fits its store: its audit, of which nothing is kept, and what follows it."""
    audit = shlex.join(["tactiledata", "audit", store.location, "--split", name])
    export = shlex.join(["tactiledata", "export-data", store.location, "--to", "lerobot", "--split", name])
    return [f"next: {audit}", f"where the audit found no leak: train from it (docs/loading.md), or {export}"]


def stale_split(store: Store, name: str) -> str:
    """Say that a split is out of date, with the command that draws it again with its own options."""
    return f"the split {name} is out of date; draw it again: {_drawn_again(store, name)}"


def flagged_split(store: Store, name: str, count: int) -> str:
    """Say that a split holds trajectories that were flagged since, with the command that draws it without them.

    Parameters
    ----------
    store : Store
    name : str
        Of the split.
    count : int
        How many such trajectories there are.
    """
    what = f"{counted(count, 'trajectory')} that {agreeing(count, 'was', 'were')} flagged since"
    return f"the split {name} holds {what}; draw it again: {_drawn_again(store, name)}"


def _drawn_again(store: Store, name: str) -> str:
    """Return the command that draws a split again with the options that it was drawn with, where they can be read."""
    from tactiledata.splits.again import command
    from tactiledata.splits.manifest import read_split_document

    try:
        document = read_split_document(store, name)
    except TactileDataError:
        document = None
    if document is None:
        return shlex.join(["tactiledata", "split", store.location, "--name", name, "--replace"])
    return command(store.location, name, document["options"])
