"""Trajectories flagged as bad, and flags taken off or carried into another store; safe to kill at any moment."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from tactiledata.contract.provenance import provenance
from tactiledata.contract.records import Finding
from tactiledata.contract.wording import agreeing, counted
from tactiledata.errors import UsageError
from tactiledata.store.layout.flag_file import FlagEntries, write_flags
from tactiledata.store.layout.lock import waiting_lock
from tactiledata.store.layout.places import FLAGS_LOCK
from tactiledata.store.read.flags import flag_origins, flagged_trajectories, is_of_copy, stored_flags
from tactiledata.store.read.named_trajectories import full_names, named_trajectories
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import store_errors

LONGEST_REASON = 500


@contextmanager
def _changing_flags(folder: Path) -> Iterator[FlagEntries]:
    """Give the block a store's flags to change; they are written where it changed them, by one process at a time."""
    with waiting_lock(folder, FLAGS_LOCK):
        entries = stored_flags(Store.open(folder))
        before = {uid: dict(entry) for uid, entry in entries.items()}
        yield entries
        if entries != before:
            with store_errors(folder):
                write_flags(folder, entries)


def flag_trajectories(store_path: Path | str, names: Sequence[str], reason: str) -> list[str]:
    """Flag trajectories as bad; return the full names of those whose flag is new or has another reason than before.

    All of them are flagged, or none: the file of flags is written once, whole. The same call again is no change. One
    that is flagged already keeps its reason where the new one says only that it is a copy.

    Parameters
    ----------
    store_path : Path or str
        Folder of a local store.
    names : sequence of str
        Uids, names, or full names of trajectories; names of recordings, for all their trajectories.
    reason : str
        Why, in words: 1 to 500 characters.

    Raises
    ------
    UnknownName, UsageError
        No trajectory has one of the names, or several have it; a reason that says nothing, or too much.
    SchemaError
        The file of flags is damaged.
    StoreError
        The store cannot be written to.
    """
    said = " ".join(reason.split())
    if not said or len(said) > LONGEST_REASON:
        raise UsageError(
            f"a reason of {len(said)} characters",
            f"1 to {LONGEST_REASON} characters",
            "Say in a sentence what is wrong with the trajectory.",
        )
    folder = Path(store_path)
    store = Store.open(folder)
    rows = named_trajectories(store, names, whole_recordings=True)
    full = full_names(store)
    keys = store.sources(["key"])["key"].to_pylist()
    table = store.trajectories(["uid", "trajectory", "source"]).to_pylist()
    made = provenance("flag", {"store": store.digest}, {"reason": said})
    changed = []
    with _changing_flags(folder) as entries:
        for row in rows:
            facts = table[row]
            before = entries.get(facts["uid"], {}).get("reason", "")
            if before == said or (before and is_of_copy(said)):
                continue
            entries[facts["uid"]] = {
                "trajectory": facts["trajectory"],
                "recording": keys[facts["source"]],
                "reason": said,
                "provenance": made,
            }
            changed.append(full[row])
    return changed


def remove_flags(store_path: Path | str, names: Sequence[str]) -> list[str]:
    """Take the flags of trajectories off; return the full names of these.

    Parameters
    ----------
    store_path : Path or str
        Folder of a local store.
    names : sequence of str
        Uids, names, or full names of trajectories; names of recordings, for their flagged trajectories. The uid of a
        flag serves, too, whose trajectory the store does not hold.

    Raises
    ------
    UnknownName, UsageError
        No trajectory has one of the names, or several have it; one of them carries no flag.
    SchemaError
        The file of flags is damaged.
    StoreError
        The store cannot be written to.
    """
    folder = Path(store_path)
    store = Store.open(folder)
    uids = store.trajectories(["uid"])["uid"].to_pylist()
    with _changing_flags(folder) as entries:
        chosen: list[str] = []
        for name in names:
            meant = [name] if name in entries else [uids[row] for row in named_trajectories(store, [name], True)]
            own = [uid for uid in meant if uid in entries]
            if not own:
                raise _no_own_flag(store, name, meant[0], entries)
            chosen += own
        return [_full_name(entries.pop(uid)) for uid in dict.fromkeys(chosen)]


def _full_name(entry: dict[str, str]) -> str:
    return f"{entry['recording']}/{entry['trajectory']}"


def _no_own_flag(store: Store, named: str, uid: str, entries: FlagEntries) -> UsageError:
    """The error for a trajectory that carries no flag itself."""
    table = store.trajectories(["uid", "parent"])
    origin = flag_origins(table["uid"].to_pylist(), table["parent"].to_pylist(), entries).get(uid)
    if origin is None:
        flagged = ", ".join(map(_full_name, entries.values()))
        return UsageError(
            f"{named} is not flagged",
            f"one that is: {flagged}" if flagged else "one that is; none of this store is",
            "`tactiledata flag STORE --list` shows all flags.",
        )
    return UsageError(
        f"the trajectory {uid} carries no flag itself: it was derived from {origin}, which does",
        "a trajectory that carries a flag",
        f"Take off the flag of {origin}.",
    )


def _with_derived(store: Store) -> FlagEntries:
    """The flags of a store, and one for each trajectory that is flagged through another one."""
    entries = stored_flags(store)
    inherited = {uid: flag for uid, flag in flagged_trajectories(store).items() if flag.origin != uid}
    recordings = {uid: flag.name.rpartition("/") for uid, flag in inherited.items()}
    own = {
        uid: {**entries[flag.origin], "recording": recordings[uid][0], "trajectory": recordings[uid][2]}
        for uid, flag in inherited.items()
    }
    return {**entries, **own}


def carry_flags(origins: Sequence[Store], target: Path, derived: bool = False) -> list[Finding]:
    """Give a store the flags of the stores that its trajectories come from, and say how many are new there.

    Call it before the trajectories are committed, so that none of them is ever there without its flag. A flag that the
    store has already stays with its reason.

    Parameters
    ----------
    origins : sequence of Store
    target : Path
        A local store.
    derived : bool
        Whether the target gets what is derived from the trajectories of ``origins``, and not these themselves. Then
        a trajectory of ``origins`` that is flagged through its own parent gets a flag of its own: the target does not
        know that parent.
    """
    carried = [_with_derived(store) if derived else stored_flags(store) for store in origins]
    if not any(carried):
        return []
    fresh, otherwise = 0, 0
    with _changing_flags(target) as entries:
        for uid, entry in ((uid, entry) for flags in carried for uid, entry in flags.items()):
            if uid not in entries:
                entries[uid] = entry
                fresh += 1
            else:
                otherwise += entries[uid]["reason"] != entry["reason"]
    findings = []
    if fresh:
        message = (
            f"{counted(fresh, 'flag')} of bad trajectories came along; what {agreeing(fresh, 'it is', 'they are')} on, "
            "and what was derived from that, is left out of splits"
        )
        findings.append(Finding("flags-carried", "info", message, count=fresh))
    if otherwise:
        are = f"{counted(otherwise, 'flag')} {agreeing(otherwise, 'has', 'have')}"
        message = f"{are} another reason in the store than where it comes from; the store's own stays"
        findings.append(Finding("flags-carried", "info", message, count=otherwise))
    return findings
