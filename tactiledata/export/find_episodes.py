"""Which episodes an export holds: the parts of a split, one camera, streams of numbers, an action."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pyarrow as pa

from tactiledata.errors import MissingSplit, UnknownName, UsageError
from tactiledata.export.episodes import Episodes
from tactiledata.export.plan import NO_ACTION, NO_SPLIT, USUAL_ACTION, ExportPlan
from tactiledata.loaders.index import FrameIndex, build_index
from tactiledata.loaders.selection import ALL, FILTERED, select
from tactiledata.loaders.streams import Stream, find_streams
from tactiledata.splits.manifest import load_split, partition_rows
from tactiledata.splits.options import PARTITIONS
from tactiledata.store.read.reader import Store

UNSPLIT = "unsplit"
"""The only part where no split is named."""
WITHOUT_CONTACT = "of trajectories of which the split takes no frame"
VECTORS = ("aligned", "frame_value", "mesh_wrench")
"""Kinds of streams that have a row of numbers a frame."""


def find_episodes(store: Store, plan: ExportPlan, may_be_empty: bool = False) -> Episodes:
    """Return what an export of a store holds.

    Parameters
    ----------
    store : Store
        What is exported.
    plan : ExportPlan
        Split, camera, streams and action.
    may_be_empty : bool
        Whether a store without a readable frame may go out, and one with several cameras.

    Raises
    ------
    MissingSplit, UnknownName, LeakError
        No split is named where several or none are there, it does not exist, or it is out of date.
    UsageError
        Several cameras and none is named, a stream that has no row of numbers a frame, or no frame at all.
    """
    camera = "" if may_be_empty else _camera(store, plan.camera)
    streams = _streams(store, plan.streams)
    action = _action(store, plan.action)
    is_parted = plan.split != NO_SPLIT
    named = {part: f"{plan.split}/{part}" for part in PARTITIONS} if is_parted else {UNSPLIT: ALL}
    indexes: list[FrameIndex] = []
    parts: list[str] = []
    left_out: dict[str, int] = {}
    for part, name in named.items():
        selection = select(store, name, camera or None, whole=is_parted, allow_leaks=True)
        index = build_index(store, selection, "trajectory")
        indexes.append(index)
        parts += [part] * len(index)
        for reason, count in selection.report.left_out.items():
            # of whole trajectories nothing is filtered: these have no frame that the split takes
            words = WITHOUT_CONTACT if reason == FILTERED else reason
            left_out[words] = left_out.get(words, 0) + count
    index = _joined(indexes)
    if not len(index) and not may_be_empty:
        raise UsageError(
            f"nothing to export from {store.location}: split {plan.split!r} has no trajectory with a readable frame",
            "at least one",
            "`tactiledata info` shows what the store holds; --split none takes all trajectories.",
        )
    excluded = _excluded(store, plan)
    outside = store.n_frames - len(index.rows) - sum(left_out.values()) - excluded
    left_out |= {"of trajectories that the split excludes": excluded, "outside any trajectory": outside}
    left_out = {reason: count for reason, count in left_out.items() if count}
    return Episodes(store, camera, streams, action, index, tuple(parts), left_out)


def chosen_split(store: Store, named: str | None, is_needed: bool) -> str:
    """Return the split that an export follows: the named one, else ``default``.

    Parameters
    ----------
    store : Store
        What is exported.
    named : str, optional
        What the user asked for.
    is_needed : bool
        Whether a store without any split is refused.

    Raises
    ------
    MissingSplit
        None is named, and there is no split called default.
    """
    if named is not None:
        if named != NO_SPLIT:
            load_split(store, named)
        return named
    names = store.split_names()
    if "default" in names:
        return "default"
    if not is_needed and not names:
        return NO_SPLIT
    listed = f"it has {', '.join(names)}" if names else "it has none yet"
    raise MissingSplit(
        f"no split is named, and the store {store.location} has none that is called default ({listed})",
        "a split, so that nobody tests on what was learned from",
        f"`tactiledata split {store.location}` makes one; --split NAME takes another; --split none exports unparted.",
    )


def _camera(store: Store, named: str) -> str:
    if named:
        if named not in store.cameras:
            raise UnknownName("camera", named, store.cameras)
        return named
    if len(store.cameras) > 1:
        raise UsageError(
            f"the store {store.location} has {len(store.cameras)} cameras: {', '.join(store.cameras)}",
            "one: a frame is one image of one camera",
            "Name it with --camera, and make an export for each.",
        )
    return next(iter(store.cameras), "")


def _streams(store: Store, names: Sequence[str] | None) -> tuple[Stream, ...]:
    chosen = (*store.aligned_names, *store.frame_value_names) if names is None else tuple(names)
    if names is not None and not names:
        raise UsageError("no stream is named", "names of streams", f"The store has {', '.join(store.aligned_names)}.")
    if not chosen:
        return ()
    streams = find_streams(store, tuple(dict.fromkeys(chosen)), "frame")
    for stream in streams:
        if stream.kind not in VECTORS:
            raise UsageError(
                f"the stream {stream.name!r} ({stream.kind}) has no row of numbers a frame",
                "values at the frames: signals, annotated values, mesh_wrench",
                "Pictures go out by --camera; meshes stay in the store.",
            )
    return streams


def _action(store: Store, named: str) -> Stream | None:
    """Return the stream whose next value is the action; ``None`` where none is wanted, or no pose is there."""
    if named not in ("", NO_ACTION, *store.aligned_names):
        raise UnknownName("stream for the action", named, [*store.aligned_names, NO_ACTION])
    wanted = named or USUAL_ACTION
    return _streams(store, (wanted,))[0] if wanted in store.aligned_names else None


def _joined(indexes: Sequence[FrameIndex]) -> FrameIndex:
    """Return the indexes of several parts of one store as one, in their order."""
    first, arrays = indexes[0], ("rows", "t_ns", "trajectory", "in_split")
    offsets = np.cumsum([0, *(len(index.rows) for index in indexes)])
    starts = [index.starts[:-1] + offset for index, offset in zip(indexes, offsets[:-1], strict=True)]
    names = sorted({name for index in indexes for name in index.sensor_names})
    codes = [
        np.array([names.index(name) for name in index.sensor_names], np.int32)[index.sensor_code] for index in indexes
        if len(index.sensor_names)
    ]  # fmt: skip
    return replace(
        first,
        **{name: np.concatenate([getattr(index, name) for index in indexes]) for name in arrays},
        starts=np.concatenate([*starts, offsets[-1:]]),
        sensor_code=np.concatenate(codes) if codes else first.sensor_code,
        sensor_names=tuple(names),
    )


def _excluded(store: Store, plan: ExportPlan) -> int:
    """Return how many frames are of trajectories that are in no part of the split."""
    if plan.split == NO_SPLIT:
        return 0
    uids: pa.ChunkedArray = store.trajectories(["uid"])["uid"]
    is_excluded = np.append(
        ~np.isin(partition_rows(load_split(store, plan.split), uids).astype(str), PARTITIONS), False
    )
    return int(is_excluded[store.frames(["trajectory"])["trajectory"].to_numpy()].sum())
