"""Values that were not recorded: which items of a dataset lack them, counted by stream."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UnknownName
from tactiledata.loaders.index import FrameIndex
from tactiledata.loaders.selection import LoadReport
from tactiledata.loaders.streams import Stream, values_at_frames

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

Missing = Literal["warn", "keep", "drop"]
MISSING_CHOICES = ("warn", "keep", "drop")
CHUNK_ROWS = 65_536


class MissingValuesWarning(UserWarning):
    """A dataset gives NaN, or signals without samples, and nobody said that this is meant."""


@dataclass(frozen=True)
class Gaps:
    """The items of a dataset in which one stream has no values.

    Parameters
    ----------
    rows : int
        Frames (for a signal at its native rate: samples) with NaN in any column.
    trajectories : int
        Trajectories with such rows, or without any row.
    empty : int
        Those of them that have no value at all.
    unit : "frames" or "samples"
    """

    rows: int
    trajectories: int
    empty: int
    unit: str = "frames"

    def __str__(self) -> str:
        where = f"{self.trajectories} trajectories lack values ({self.rows} {self.unit} with NaN"
        return f"{where}; {self.empty} of the trajectories have none at all)"

    def document(self) -> dict[str, Any]:
        """The gaps as JSON values."""
        return dict(vars(self))


def treat_missing(
    store: Store, index: FrameIndex, streams: tuple[Stream, ...], report: LoadReport, missing: Missing
) -> tuple[FrameIndex, LoadReport]:
    """Return what a dataset holds once missing values are warned of, kept, or left out with their items.

    Parameters
    ----------
    store : Store
        Where the values are.
    index : FrameIndex
        Items of the dataset.
    streams : tuple of Stream
        Streams of the dataset.
    report : LoadReport
        What the dataset holds so far.
    missing : "warn", "keep" or "drop"
        What to do with items that lack values.

    Raises
    ------
    UnknownName
        Another word than "warn", "keep" or "drop".
    """
    if missing not in MISSING_CHOICES:
        raise UnknownName("choice for missing values", str(missing), MISSING_CHOICES)
    gaps, lacking = find_gaps(store, index, streams)
    if not gaps:
        return index, report
    if missing == "drop":
        return _dropped(index, lacking, report)
    if missing == "warn":
        told = "; ".join(f"{stream}: {found}" for stream, found in gaps.items())
        warnings.warn(
            f"{report.split} of {store.location}: {told}. Say missing='drop' to leave such items out, or "
            "missing='keep' where NaN is meant.",
            MissingValuesWarning,
            stacklevel=3,
        )
    return index, replace(report, missing=gaps)


def _dropped(
    index: FrameIndex, lacking: Mapping[str, NDArray[np.bool_]], report: LoadReport
) -> tuple[FrameIndex, LoadReport]:
    frames = np.diff(index.starts)
    dropped = np.zeros(len(index), bool)
    left_out = dict(report.left_out)
    for stream, items in lacking.items():  # an item that lacks several is counted once, so that counts add up
        left_out[f"without values of {stream}"] = int(frames[items & ~dropped].sum())
        dropped |= items
    kept = index.only(~dropped)
    held = len(np.unique(kept.trajectory[kept.trajectory >= 0]))
    counts = {reason: count for reason, count in left_out.items() if count}
    return kept, replace(report, frames=len(kept.rows), trajectories=held, left_out=counts)


def find_gaps(
    store: Store, index: FrameIndex, streams: tuple[Stream, ...]
) -> tuple[dict[str, Gaps], dict[str, NDArray[np.bool_]]]:
    """Return the gaps of each stream that has any, and which items (n_items,) lack values of it.

    A stream whose values are finite all over the store is not read.

    Parameters
    ----------
    store : Store
        Where the values are.
    index : FrameIndex
        Items of the dataset.
    streams : tuple of Stream
        Streams of the dataset; pictures are passed over.
    """
    gaps: dict[str, Gaps] = {}
    lacking: dict[str, NDArray[np.bool_]] = {}
    for stream in streams:
        if stream.is_picture:
            continue
        found, items = _of_signal(store, index, stream) if stream.kind == "signal" else _of_frames(store, index, stream)
        if items.any():
            gaps[stream.name], lacking[stream.name] = found, items
    return gaps, lacking


def _is_finite_everywhere(facts: Mapping[str, Any], rows: int) -> bool:
    return all(count == rows for count in facts["statistics"]["count"])


def _of_frames(store: Store, index: FrameIndex, stream: Stream) -> tuple[Gaps, NDArray[np.bool_]]:
    bad = np.zeros(len(index.rows), bool)
    if stream.is_of_mesh:
        bad = ~store.mesh(stream.mesh).has_mesh(index.rows)
    elif not _is_finite_everywhere(_facts(store, stream), store.n_frames):
        for start in range(0, len(bad), CHUNK_ROWS):
            rows = index.rows[start : start + CHUNK_ROWS]
            bad[start : start + CHUNK_ROWS] = np.isnan(values_at_frames(store, stream, rows)).any(axis=1)
    touched = np.unique(index.trajectory[bad])
    filled = np.unique(index.trajectory[~bad])
    empty = np.setdiff1d(touched, filled, assume_unique=True)
    counts = np.concatenate([[0], np.cumsum(bad)])
    return Gaps(int(bad.sum()), len(touched), len(empty)), np.diff(counts[index.starts]) > 0


def _facts(store: Store, stream: Stream) -> Mapping[str, Any]:
    facts: Mapping[str, Any] = store.manifest["aligned" if stream.kind == "aligned" else "frame_values"][stream.name]
    return facts


def _of_signal(store: Store, index: FrameIndex, stream: Stream) -> tuple[Gaps, NDArray[np.bool_]]:
    signal = store.signal(stream.name)
    is_finite = _is_finite_everywhere(store.manifest["signals"][stream.name], signal.n_rows)
    samples = np.zeros(len(index), np.int64)
    bad = np.zeros(len(index), np.int64)
    for item, (start, stop) in enumerate(_segments(index, stream.name)):
        samples[item] = stop - start
        if not is_finite:
            bad[item] = np.isnan(signal.values(start, stop)).any(axis=1).sum()
    lacking = (bad > 0) | (samples == 0)
    return Gaps(int(bad.sum()), int(lacking.sum()), int((bad == samples).sum()), "samples"), lacking


def _segments(index: FrameIndex, signal: str) -> Iterator[tuple[int, int]]:
    for start in index.starts[:-1]:
        yield index.segment(int(index.trajectory[start]), signal)
