"""A split made and kept: options and a store in, files beside the store out."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pyarrow as pa

from tactiledata.contract.wording import agreeing, counted
from tactiledata.errors import SchemaError, StoreError, UsageError
from tactiledata.splits.again import command, typed_options
from tactiledata.splits.assign import Held, assign, choose_held_out, describe_held, need_units
from tactiledata.splits.flagged import flag_change_notes, flag_notes
from tactiledata.splits.groups import group_trajectories
from tactiledata.splits.manifest import read_split, read_split_document, write_split
from tactiledata.splits.options import HoldOut, SplitOptions, check_name
from tactiledata.splits.report import SplitReport, count_parts, count_strata, notes_on
from tactiledata.splits.select import FRAME_COLUMNS, check_force_filter, frames_per_trajectory, taken_frames
from tactiledata.store.read.flags import Flag, flagged_trajectories

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

TRAJECTORY_COLUMNS = ("uid", "trajectory", "source", "sensor", "indenter", "start_ns", "end_ns", "parent")


def make_split(
    store: Store,
    name: str = "default",
    by: Sequence[str] | str = ("trajectory", "sensor"),
    hold_out: HoldOut | str | None = "auto",
    fractions: Sequence[float] | str = (0.8, 0.1, 0.1),
    force: Sequence[float] | str | None = (1.0, 13.0),
    seed: int = 0,
    replace: bool = False,
    with_flagged: bool = False,
) -> SplitReport:
    """A split of a store, written beside it.

    A split of that name that was made with the same options is brought up to date: its held-out units stay, and
    nobody who has a part is moved.

    Parameters
    ----------
    store : Store
        Local; it is not changed apart from its folder ``splits``.
    name : str
    by : "trajectory" and the unit kinds that make strata
    hold_out : "auto", "none", a dict of unit kind -> names, or text as on the command line
    fractions : shares of train, val and test
    force : (lowest, highest) N, or None
    seed : int
    replace : bool
        Make it anew even where one of that name exists with other options; its parts and held-out units are forgotten.
    with_flagged : bool
        Take flagged trajectories, too; they are left out by default, with what was derived from them.

    Raises
    ------
    UsageError
        Options that make no sense, would leak, or differ from those of the split that exists.
    UnknownName
        A unit to hold out that the store does not hold.
    StoreError
        Nothing to split, a damaged store, a disk that is full.
    """
    options = SplitOptions.checked(by, hold_out, fractions, force, seed, with_flagged)
    path = _local_path(store, check_name(name))
    trajectories = store.trajectories(list(TRAJECTORY_COLUMNS))
    frames = store.frames(list(FRAME_COLUMNS))
    need_units(trajectories, options)
    before = None if replace else _existing(store, name, options)
    flags = flagged_trajectories(store)
    kept = None if before is None else before["held_out"]
    report, table = split_tables(name, trajectories, frames, options, kept, flags)
    moved = _moved(store, name, table, report.flagged) if before is not None else []
    report = SplitReport(**{**vars(report), "notes": (*report.notes, *moved)})
    state = {"digest": store.digest, "trajectories": trajectories.num_rows, "frames": frames.num_rows}
    write_split(path, report, table, state)
    return report


def split_tables(
    name: str,
    trajectories: pa.Table,
    frames: pa.Table,
    options: SplitOptions,
    kept: Held | None = None,
    flags: Mapping[str, Flag] | None = None,
) -> tuple[SplitReport, pa.Table]:
    """A split of tables: what `make_split` writes, with nothing written.

    Parameters
    ----------
    name : str
    trajectories, frames : pa.Table
        The columns ``TRAJECTORY_COLUMNS`` and ``select.FRAME_COLUMNS``.
    options : SplitOptions
    kept : dict, unit kind -> names, optional
        Held-out units of the split that is brought up to date.
    flags : dict, uid -> Flag, optional
        Flagged trajectories.
    """
    if not trajectories.num_rows:
        raise StoreError(
            "the store holds no trajectories",
            "at least two to split",
            "Ingest recordings first: `tactiledata ingest PATH…`.",
        )
    groups = len(set(group_trajectories(trajectories).moment))
    if groups < 2:
        raise StoreError(
            "the store has one trajectory"
            if trajectories.num_rows == 1
            else f"all {trajectories.num_rows} trajectories of the store must stand together: one group",
            "at least two, so that something is on the other side",
            "Ingest more recordings; a trajectory is never parted.",
        )
    taken = taken_frames(frames, options.force)
    notes = check_force_filter(frames, taken, options.force)
    held_out, why = choose_held_out(trajectories, options)
    if kept is not None and (before := {kind: tuple(names) for kind, names in kept.items()}) != held_out:
        why = [f"held out as before: {describe_held(before)}; this store alone would give {describe_held(held_out)}"]
        held_out = before
    counted = frames_per_trajectory(frames, taken, trajectories.num_rows)
    left_out = {} if options.with_flagged or flags is None else flags
    table = assign(trajectories, options, held_out, counted, left_out)
    counts, strata = count_parts(table), count_strata(table, options.strata)
    notes += [*flag_notes(flags or {}, options), *why]
    notes += notes_on(table, options, held_out, counts, strata, left_out)
    return SplitReport(name, options, held_out, counts, strata, tuple(notes), tuple(left_out)), table


def _local_path(store: Store, name: str) -> Path:
    path = str(store.split_path(name))
    if "://" in path and not path.startswith("file://"):
        raise UsageError(
            f"the store {store.location} is not on a local disk",
            "a local store",
            "Split it on the machine that holds it.",
        )
    return Path(path.removeprefix("file://"))


def _existing(store: Store, name: str, options: SplitOptions) -> dict[str, Any] | None:
    try:
        document = read_split_document(store, name)
    except SchemaError as error:
        raise StoreError(
            f"a split {name!r} exists and cannot be read: {error}",
            "a split whose held-out units can be kept",
            "Use --replace to make it anew, or another --name.",
        ) from error
    if document is None:
        return None
    if document["options"] != options.document():
        there, here = document["options"], options.document()
        differ = [key for key in {**there, **here} if there.get(key) != here.get(key)]
        was, asked = typed_options(there), typed_options(here)
        raise UsageError(
            f"a split {name!r} exists that was made with other options ("
            + "; ".join(f"{was[key]} there, {asked[key]} here" for key in differ)
            + ")",
            "the same options, to bring it up to date",
            f"That is `{command(store.location, name, document['options'])}`. Else choose another --name, or --replace "
            "it (results on the old one can then not be compared with the new).",
        )
    return document


def _moved(store: Store, name: str, table: pa.Table, flagged: Collection[str]) -> list[str]:
    """Say who has another part than before: nobody, unless a flag was set or taken off, a missing parent turned up, or
    a table was changed.
    """
    try:
        split = read_split(store, name)
    except StoreError as error:
        return [f"the split that existed was not whole, and was made again ({error.found})"]
    old, was_flagged = split.table, set(split.document.get("flagged", ()))
    before = dict(zip(old["uid"].to_pylist(), old["partition"].to_pylist(), strict=True))
    now = zip(table["uid"].to_pylist(), table["partition"].to_pylist(), strict=True)
    all_moved = [uid for uid, part in now if before.get(uid, part) != part]
    notes = flag_change_notes(all_moved, was_flagged, flagged)
    moved = [uid for uid in all_moved if (uid in was_flagged) == (uid in flagged)]
    if not moved:
        return notes
    are = f"{counted(len(moved), 'trajectory')} {agreeing(len(moved), 'is', 'are')}"
    return [
        *notes,
        f"{are} in another part than before (first {moved[0]}): what {agreeing(len(moved), 'it was', 'they were')} "
        "derived from is now in the store, or belongs to a held-out unit; do not compare results across this change",
    ]
