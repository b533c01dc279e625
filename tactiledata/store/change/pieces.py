"""One source of a store as what it was when it came: tables, signals and values with rows of its own."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.contract.provenance import json_bytes
from tactiledata.contract.records import FrameValues, Source, Stamps
from tactiledata.contract.take import AlignedSignal, StoredSignal, Take
from tactiledata.errors import StoreError
from tactiledata.store.check.values import source_value_findings
from tactiledata.store.read.reader import Store
from tactiledata.store.write.documents import known_sensors, need_whole_documents


@dataclass(frozen=True)
class Origin:
    """A store that sources are taken from, with its tables, which are read once."""

    store: Store
    frames: pa.Table
    trajectories: pa.Table
    findings: pa.Table
    sensors: Mapping[str, Mapping[str, Any]]

    @classmethod
    def of(cls, store: Store) -> Origin:
        """Make an origin of a store whose documents are whole.

        Raises
        ------
        StoreError
            They are not: what is written from them would carry the damage on, under digests that fit.
        """
        need_whole_documents(store)
        return cls(store, store.frames(), store.trajectories(), store.findings(), known_sensors(store))


@dataclass(frozen=True)
class Piece:
    """One source of one store: its row there, its first frame and its first trajectory there."""

    origin: Origin
    row: int
    facts: Mapping[str, Any]
    contents: Mapping[str, Any]
    first_frame: int
    first_trajectory: int

    @property
    def store(self) -> Store:
        """The store that it comes from."""
        return self.origin.store


def pieces_of(origin: Origin) -> Iterator[Piece]:
    """All sources of a store, in order."""
    frame = trajectory = 0
    for row, facts in enumerate(origin.store.sources().to_pylist()):
        yield Piece(origin, row, facts, json.loads(facts["contents"]), frame, trajectory)
        frame, trajectory = frame + facts["frames"], trajectory + facts["trajectories"]


def take_of(
    piece: Piece,
    frames: pa.Table,
    findings: pa.Table,
    sensors: Mapping[str, Mapping[str, Any]],
    left_out: Collection[str] = (),
) -> Take:
    """The source as a take, with these frames, findings and facts of sensors, and everything else as the store has it.

    A picture without contact is the one that the store keeps of that sensor; the source's own may have been another.

    Parameters
    ----------
    piece : Piece
        The source and the store that it lies in.
    frames : Table
        Rows of its frames, by `FRAME_SCHEMA`.
    findings : Table
        Its findings, by `FINDING_SCHEMA`.
    sensors : dict of dict
        Facts by sensor that the take states.
    left_out : collection of str
        Sensors whose picture without contact is not taken, and not read.

    Raises
    ------
    StoreError
        Its numbers are not those that came: a chunk that is gone reads as numbers that nobody recorded.
    """
    facts, contents, store = piece.facts, piece.contents, piece.store
    _need_own_values(piece)
    return Take(
        source=Source(facts["key"], facts["key"], facts["format"], ()),
        sha256=facts["sha256"],
        status=facts["status"],
        description=json.loads(facts["description"]),
        provenance=json.loads(facts["provenance"]),
        frames=frames,
        trajectories=_trajectories(piece),
        findings=findings,
        signals={entry["name"]: _signal(piece, name, entry) for name, entry in contents["signals"].items()},
        aligned={entry["name"]: _aligned(piece, name, entry) for name, entry in contents["aligned"].items()},
        references={
            sensor: store.reference(sensor)
            for sensor in contents["references"]
            if sensor in store.manifest["references"] and sensor not in left_out
        },
        sensors=sensors,
        frame_values={
            entry["name"]: _frame_values(piece, name, entry) for name, entry in contents["frame_values"].items()
        },
    )


def _need_own_values(piece: Piece) -> None:
    frames = (piece.first_frame, piece.first_frame + piece.facts["frames"])
    found = list(source_value_findings(piece.store, piece.facts["key"], piece.facts["contents"], frames))
    if found:
        raise StoreError(
            f"the store {piece.store.location} is damaged: {found[0].message}"
            + (f"; {len(found) - 1} more" if found[1:] else ""),
            "the numbers that were ingested",
            "Ingest all recordings that `tactiledata check` names in one command, with --replace: none of them can be "
            "mended alone.",
            key=piece.facts["key"],
        )


def rows_of(table: pa.Table, source: int) -> pa.Table:
    """Rows of a source, which are side by side, as rows of source 0."""
    start, stop = np.searchsorted(np.asarray(table["source"]), [source, source + 1]).tolist()
    rows = table.slice(start, stop - start)
    return rows.set_column(rows.schema.get_field_index("source"), "source", pa.array(np.zeros(len(rows)), pa.int32()))


def parents(piece: Piece, parents: NDArray[np.int64], starts: Mapping[str, int]) -> NDArray[np.int64]:
    """Row numbers of parents in another store, from those in the piece's.

    Parameters
    ----------
    piece : Piece
        The source that the frames belong to.
    parents : (n,) int64
        Rows in the table of frames of the piece's store; negative for a frame without a parent.
    starts : dict
        First frame in the other store of each source that is there, by digest.
    """
    if (parents < 0).all():
        return parents
    others = list(pieces_of(piece.origin))
    firsts = np.array([other.first_frame for other in others])
    new = np.array([starts.get(other.facts["sha256"], -1) for other in others])
    of = np.searchsorted(firsts, np.maximum(parents, 0), side="right") - 1
    return np.where((parents < 0) | (new[of] < 0), -1, parents - firsts[of] + new[of])


def _trajectories(piece: Piece) -> pa.Table:
    table = piece.origin.trajectories.slice(piece.first_trajectory, piece.facts["trajectories"])
    signals = piece.contents["signals"]
    ranges = [
        {
            signals[name]["name"]: [row - signals[name]["rows"][0] for row in pair]
            for name, pair in json.loads(text).items()
        }
        for text in table["signal_rows"].to_pylist()
    ]
    changed = {
        "source": pa.array(np.zeros(len(table)), pa.int32()),
        "frame_start": pa.array(np.asarray(table["frame_start"]) - piece.first_frame, pa.int64()),
        "frame_stop": pa.array(np.asarray(table["frame_stop"]) - piece.first_frame, pa.int64()),
        "signal_rows": pa.array([json_bytes(entry).decode() for entry in ranges], pa.string()),
    }
    for name, values in changed.items():
        table = table.set_column(table.schema.get_field_index(name), table.schema.field(name), values)
    return table


def _signal(piece: Piece, stored: str, facts: Mapping[str, Any]) -> StoredSignal:
    signal = piece.store.signal(stored)
    start, stop = facts["rows"]
    log, publish, header = (signal.stamps(kind, start, stop) for kind in ("log", "publish", "header"))
    return StoredSignal(
        signal.t_ns(start, stop),
        signal.values(start, stop),
        signal.columns,
        signal.units,
        signal.frame,
        Stamps(log, publish, header),
        facts["attributes"],
    )


def _aligned(piece: Piece, stored: str, facts: Mapping[str, Any]) -> AlignedSignal:
    meaning = piece.store.meaning("aligned", stored)
    values, gap_ns = piece.store.aligned(stored, _frame_rows(piece))
    method = facts["attributes"]["method"]
    return AlignedSignal(values, gap_ns, meaning.columns, meaning.units, meaning.frame, method)


def _frame_values(piece: Piece, stored: str, facts: Mapping[str, Any]) -> FrameValues:
    meaning = piece.store.meaning("frame_values", stored)
    values = piece.store.frame_values(stored, _frame_rows(piece))
    return FrameValues(values, meaning.columns, meaning.units, facts["attributes"]["note"])


def _frame_rows(piece: Piece) -> NDArray[np.int64]:
    return np.arange(piece.first_frame, piece.first_frame + piece.facts["frames"])
