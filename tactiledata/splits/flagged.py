"""What flags of bad trajectories mean for a split: who is left out, and which parts hold one that was flagged since."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

from tactiledata.contract.records import Finding
from tactiledata.contract.wording import agreeing, counted
from tactiledata.splits.manifest import Split
from tactiledata.splits.options import PARTITIONS, SplitOptions
from tactiledata.store.read.flags import Flag, flag_origins, flag_words, flagged_trajectories, stored_flags

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

FLAGGED = "flagged-in-split"
SHOWN = 3
"""Flagged trajectories that a sentence names before it says how many more there are."""


def flag_notes(flags: Mapping[str, Flag], options: SplitOptions) -> list[str]:
    """What a split says of flagged trajectories: left out, or taken as it was asked to; nothing where there are none.

    Parameters
    ----------
    flags : dict, uid -> Flag
        Flagged trajectories of the store.
    options : SplitOptions
    """
    if not flags:
        return []
    what = f"{counted(len(flags), 'flagged trajectory')} ({flag_words(flags, SHOWN)})"
    if options.with_flagged:
        return [f"taken as any other, as was asked for: {what}"]
    return [f"in no part: {what}; --with-flagged takes {agreeing(len(flags), 'it', 'them')}"]


def flag_change_notes(moved: Sequence[str], before: Collection[str], now: Collection[str]) -> list[str]:
    """What a split says of trajectories that left a part, or came back, since flags were set or taken off.

    Parameters
    ----------
    moved : sequence of str
        Uids of the trajectories that have another part than before.
    before, now : collection of str
        Uids that were, and are, left out because they are flagged.
    """
    left = [uid for uid in moved if uid in now and uid not in before]
    back = [uid for uid in moved if uid in before and uid not in now]
    notes = []
    if left:
        notes.append(
            f"{counted(len(left), 'trajectory')} left {agreeing(len(left), 'its part', 'their parts')}: flagged"
        )
    if back:
        are = agreeing(len(back), "is", "are")
        notes.append(f"{counted(len(back), 'trajectory')} {are} in a part again: no longer flagged")
    return notes


def flagged_in_parts(store: Store, split: Split, part: str | None = None) -> list[Flag]:
    """Flagged trajectories that a split holds in a part; none where it was asked to take them.

    Parameters
    ----------
    store : Store
    split : Split
    part : str, optional
        One of the parts; all unless given.
    """
    flags = {} if split.options.with_flagged else flagged_trajectories(store)
    return _held(flags, split, (part,) if part else PARTITIONS)


def _held(flags: Mapping[str, Flag], split: Split, parts: Collection[str]) -> list[Flag]:
    """The flags of the trajectories that a split holds in some of its parts."""
    if not flags:
        return []
    part_of = dict(zip(split.table["uid"].to_pylist(), split.table["partition"].to_pylist(), strict=True))
    return [flag for uid, flag in flags.items() if part_of.get(uid) in parts]


def flag_findings(store: Store, split: Split, again: str) -> list[Finding]:
    """What an audit finds of flags: flagged trajectories in a part, and those left out whose flag is gone.

    Parameters
    ----------
    store : Store
    split : Split
    again : str
        The command that brings the split up to date.
    """
    flags = flagged_trajectories(store)
    found = []
    if split.options.with_flagged:
        if flags:
            message = f"the split was asked to take flagged trajectories: {flag_words(flags, SHOWN)}"
            found.append(Finding("flagged-taken", "info", message, count=len(flags)))
        return found
    if held := _held(flags, split, PARTITIONS):
        what = f"{counted(len(held), 'trajectory')} in the parts {agreeing(len(held), 'was', 'were')} flagged"
        message = f"{what} since the split was drawn: {flag_words(held, SHOWN)}; run `{again}` again"
        found.append(Finding(FLAGGED, "damage", message, count=len(held)))
    there = set(split.table["uid"].to_pylist())
    if free := [uid for uid in split.document.get("flagged", ()) if uid in there and uid not in flags]:
        are = f"{counted(len(free), 'trajectory')} {agreeing(len(free), 'is', 'are')}"
        message = f"{are} in no part because of a flag that was taken off since; run `{again}` again"
        found.append(Finding("flag-taken-off", "warning", message, count=len(free)))
    return found


def flagged_parent_findings(children: Store, parents: Store, split: Split) -> list[Finding]:
    """What an audit of derived trajectories finds where their origin was flagged in another store since.

    Parameters
    ----------
    children, parents : Store
        The store of the derived trajectories, and that of the origins.
    split : Split
        Split of the children's store.
    """
    known = flagged_trajectories(children)
    reasons = {uid: entry["reason"] for uid, entry in stored_flags(parents).items()}
    reasons |= {uid: flag.reason for uid, flag in flagged_trajectories(parents).items()}
    if split.options.with_flagged or not reasons:
        return []
    table = children.trajectories(["uid", "parent"])
    origins = flag_origins(table["uid"].to_pylist(), table["parent"].to_pylist(), reasons)
    part_of = dict(zip(split.table["uid"].to_pylist(), split.table["partition"].to_pylist(), strict=True))
    held = [uid for uid in origins if uid not in known and part_of.get(uid) in PARTITIONS]
    if not held:
        return []
    message = (
        f"{counted(len(held), 'trajectory')} in the parts {agreeing(len(held), 'was', 'were')} derived from what is "
        f"flagged in {parents.location} (first {held[0]}: {reasons[origins[held[0]]]}); run the transfer "
        "again, which carries flags along, and draw the split again"
    )
    return [Finding(FLAGGED, "damage", message, count=len(held))]
