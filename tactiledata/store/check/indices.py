"""Whether the tables of a store fit one another and the arrays that they point into."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.arrays import Mask
from tactiledata.contract.records import Finding
from tactiledata.contract.wording import listed
from tactiledata.store.layout.manifest import settings_of
from tactiledata.store.read.reader import Store

FRAMES, SOURCES, TRAJECTORIES = (
    "whether frames point at what is there",
    "whether recordings have the frames and trajectories that they name",
    "whether trajectories have the frames and signals that they name",
)
INDEX_NEEDS = {
    FRAMES: ("frames",),
    SOURCES: ("frames", "trajectories", "sources"),
    TRAJECTORIES: ("frames", "trajectories"),
}
"""Checks of the tables, and the tables that they need."""


def index_findings(store: Store, broken: Collection[str] = ()) -> list[Finding]:
    """Findings ``store-index`` for rows that cannot be right, a finding a kind of fault.

    Parameters
    ----------
    broken : collection of str
        Tables that cannot be used; what needs them is left out.
    """
    able = {what for what, tables in INDEX_NEEDS.items() if not set(broken) & set(tables)}
    faults: list[tuple[str, Mask]] = []
    if FRAMES in able:
        faults += _frame_faults(store, store.frames())
    if SOURCES in able:
        faults += _source_faults(store.frames(["source"]), store.trajectories(["source"]), store.sources())
    if TRAJECTORIES in able:
        faults += _trajectory_faults(store, store.frames(["trajectory"]), store.trajectories())
    return [_finding(what, mask) for what, mask in faults if mask.any()]


def _finding(what: str, mask: Mask) -> Finding:
    rows = np.flatnonzero(mask)
    shown = listed([str(row) for row in rows], 5)
    return Finding("store-index", "damage", f"{what}: rows {shown}", count=len(rows))


def _outside(values: NDArray[Any], low: int, high: int) -> Mask:
    return (values < low) | (values >= high)


def _frame_faults(store: Store, frames: pa.Table) -> Iterator[tuple[str, Mask]]:
    rows = store.manifest["rows"]
    column = {name: np.asarray(frames[name]) for name in ("trajectory", "source", "offset", "length", "parent_frame")}
    yield "frames of a trajectory that is not there", _outside(column["trajectory"], -1, rows["trajectories"])
    yield "frames of a source that is not there", _outside(column["source"], 0, rows["sources"])
    yield "frames with a parent that is not there", _outside(column["parent_frame"], -1, rows["frames"])
    chunk = settings_of(store.manifest).heap_chunk_bytes
    start, stop = column["offset"], column["offset"] + column["length"]
    size = np.asarray(frames["height"]).astype(np.int64) << 16 | np.asarray(frames["width"])
    is_raw = _equals(frames, "encoding", "raw")
    is_encoded = _equals(frames, "encoding", "jpeg") | _equals(frames, "encoding", "png")
    known = np.zeros(len(frames), dtype=bool)
    for name, facts in store.manifest["cameras"].items():
        mine = _equals(frames, "camera", name)
        known |= mine
        wrong = (start < 0) | (stop < start) | (stop > facts["heap_bytes"])
        yield f"images of {name!r} outside its heap", mine & is_encoded & wrong
        straddles = (column["length"] > 0) & (start // chunk != (stop - 1) // chunk)
        yield f"images of {name!r} across two chunks", mine & is_encoded & straddles
        inside = np.zeros(len(frames), dtype=bool)
        for text, count in facts["rgb"].items():
            height, width = (int(side) for side in text.split("x"))
            inside |= (size == height << 16 | width) & (start >= 0) & (start < count)
        yield f"raw images of {name!r} outside their array", mine & is_raw & ~inside
    yield "frames of a camera that is not there", ~known


def _equals(frames: pa.Table, name: str, value: str) -> Mask:
    """Return a mask of rows where a column of names has a value. The column's dictionary is searched, not its rows."""
    found = [np.empty(0, dtype=bool)]
    for chunk in frames[name].chunks:
        names = chunk.dictionary.to_pylist()
        code = names.index(value) if value in names else -1
        found.append(np.asarray(chunk.indices) == code)
    return np.concatenate(found)


def _source_faults(frames: pa.Table, trajectories: pa.Table, sources: pa.Table) -> Iterator[tuple[str, Mask]]:
    for what, table in (("frames", frames), ("trajectories", trajectories)):
        of_source = np.asarray(table["source"])
        inside = of_source[~_outside(of_source, 0, len(sources))]
        counted = np.bincount(inside, minlength=len(sources))
        yield f"sources whose number of {what} is another", counted != np.asarray(sources[what])
        yield f"{what} that are not in the order of their sources", np.diff(of_source, prepend=of_source[:1]) < 0


def _trajectory_faults(store: Store, frames: pa.Table, trajectories: pa.Table) -> Iterator[tuple[str, Mask]]:
    start, stop = np.asarray(trajectories["frame_start"]), np.asarray(trajectories["frame_stop"])
    outside = (start < 0) | (stop < start) | (stop > len(frames))
    yield "trajectories with frames that are not there", outside
    yield (
        "trajectories that end before they start",
        np.asarray(trajectories["end_ns"]) < np.asarray(trajectories["start_ns"]),
    )
    uids = np.array(trajectories["uid"].to_pylist(), dtype=object).astype(str)
    _, first, count = np.unique(uids, return_index=True, return_counts=True)
    twice = np.zeros(len(uids), dtype=bool)
    twice[first[count > 1]] = True
    yield "trajectories with a uid that another has", twice
    # every frame of the range belongs to the trajectory, and the trajectory has no frame outside it
    of_frame = np.asarray(frames["trajectory"])
    expected = np.full(len(frames), -1)
    for row in np.flatnonzero(~outside).tolist():
        expected[start[row] : stop[row]] = row
    yield "frames that are in no range of their trajectory", expected != of_frame
    wrong = np.zeros(len(trajectories), dtype=bool)
    for row, text in enumerate(trajectories["signal_rows"].to_pylist()):
        wrong[row] = not _fits(store, text)
    yield "trajectories with rows of signals that are not there", wrong


def _fits(store: Store, text: str) -> bool:
    try:
        ranges = json.loads(text)
        return all(
            0 <= first <= last <= store.manifest["signals"][name]["rows"] for name, (first, last) in ranges.items()
        )
    except (ValueError, KeyError, TypeError, AttributeError):
        return False
