"""Which trajectories of a store a person called bad, and why: flagged themselves, or derived from flagged ones."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tactiledata.errors import LostFile, MissingFile
from tactiledata.store.layout.flag_file import WRITTEN, FlagEntries, parse_flags
from tactiledata.store.layout.places import FLAGS, FLAGS_LOCK
from tactiledata.store.read.recording_names import recording_names

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store


COPY = "a copy of"
"""How the reason of a touch begins that is left out because another recording holds it, too."""
OF_COPY = re.compile(r"\b(copy|copies|duplicates?|twins?)\b", re.IGNORECASE)
"""What a person writes of such a touch."""


def is_of_copy(reason: str) -> bool:
    """Whether a reason says that a touch is left out as a copy, and not that it is bad.

    Examples
    --------
    >>> is_of_copy("a copy of monday/run1.mcap"), is_of_copy("the gel slipped")
    (True, False)
    """
    return OF_COPY.search(reason) is not None


@dataclass(frozen=True)
class Flag:
    """Why a trajectory is flagged.

    Parameters
    ----------
    uid : str
        The trajectory.
    name : str
        Its recording and its name, as people read and type it.
    reason : str
        As the person gave it.
    origin : str
        Uid of the trajectory that carries the flag: its own, or one that it was derived from.
    """

    uid: str
    name: str
    reason: str
    origin: str

    @property
    def words(self) -> str:
        """The flag in words: the trajectory, its reason, and whether its origin carries it."""
        through = "" if self.origin == self.uid else f" (flagged: {self.origin}, from which it was derived)"
        return f"{self.name}: {self.reason}{through}"

    def document(self) -> dict[str, str]:
        """The flag as JSON values."""
        return dict(vars(self))


def stored_flags(store: Store) -> FlagEntries:
    """The flags that a store keeps, by uid, whether or not it holds their trajectories; empty where it keeps none.

    Raises
    ------
    SchemaError
        The file of flags is not the one that was written.
    LostFile
        There were flags, and their file is gone: nobody would know which trajectories are bad.
    """
    try:
        content = store.read_file(FLAGS)
    except MissingFile:
        if not _were_flags(store):
            return {}
        raise LostFile(
            f"{store.location}/{FLAGS} is gone, and flags were written there",
            "the flags of bad trajectories",
            f"Take it from a copy of the store. Without one, remove {FLAGS_LOCK} there and flag trajectories again.",
        ) from None
    return parse_flags(content, f"{store.location}/{FLAGS}")


def _were_flags(store: Store) -> bool:
    """Whether a store ever had a file of flags."""
    try:
        return store.read_file(FLAGS_LOCK) == WRITTEN
    except MissingFile:
        return False


def flagged_trajectories(store: Store) -> dict[str, Flag]:
    """The flagged trajectories of a store, by uid, in the order of its table.

    A trajectory is flagged where it carries a flag, or where one does that it was derived from, in this store or in
    another.
    """
    entries = stored_flags(store)
    if not entries:
        return {}
    rows = store.trajectories(["uid", "parent", "trajectory", "source"]).to_pylist()
    keys = recording_names(store)
    origins = flag_origins([row["uid"] for row in rows], [row["parent"] for row in rows], entries)
    return {
        row["uid"]: Flag(
            row["uid"],
            f"{keys[row['source']]}/{row['trajectory']}",
            entries[origins[row["uid"]]]["reason"],
            origins[row["uid"]],
        )
        for row in rows
        if row["uid"] in origins
    }


def flag_origins(uids: Sequence[str], parents: Sequence[str], flagged: Iterable[str]) -> dict[str, str]:
    """The nearest flagged uid on each trajectory's chain of parents, its own first; others are left out.

    Parameters
    ----------
    uids : (n,) str
    parents : (n,) str
        Empty for recorded trajectories. A parent that is none of ``uids`` ends the chain, and may be flagged.
    flagged : iterable of str
        Uids that carry a flag.

    Examples
    --------
    >>> flag_origins(["a", "b", "c"], ["x", "a", ""], ["x"])
    {'a': 'x', 'b': 'x'}
    """
    carries = set(flagged)
    parent_of = dict(zip(uids, parents, strict=True))
    found: dict[str, str] = {}
    for uid in uids:
        at, met = uid, set()
        while at and at not in carries and at not in met:
            met.add(at)
            at = parent_of.get(at, "")
        if at in carries:
            found[uid] = at
    return found


def flag_words(flags: Mapping[str, Flag] | Sequence[Flag], most: int) -> str:
    """The first flags in words, with semicolons between, and how many more there are.

    Parameters
    ----------
    flags : flags, or a mapping with flags as its values
    most : int
        How many are said.
    """
    listed: list[Any] = list(flags.values() if isinstance(flags, Mapping) else flags)
    more = f"; and {len(listed) - most} more" if len(listed) > most else ""
    return "; ".join(flag.words for flag in listed[:most]) + more
