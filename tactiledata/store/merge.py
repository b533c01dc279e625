"""Stores merged into one: each source becomes a take again and is committed as if it had been ingested there."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.contract.provenance import json_bytes
from tactiledata.contract.records import Encoding, Finding, FrameValues, Image, Source, Stamps
from tactiledata.contract.take import FRAME_SCHEMA, AlignedSignal, FrameFlag, StoredSignal, Take
from tactiledata.errors import StoreError, UsageError
from tactiledata.store.commit import commit_groups, create, keep_sensors, recover
from tactiledata.store.layout import INTAKE_LOCK, MANIFEST, staging_folder
from tactiledata.store.lock import writing_lock
from tactiledata.store.manifest import settings_of
from tactiledata.store.reader import Store
from tactiledata.store.spool import Spool
from tactiledata.store.writer import StagedTake, stage

BLOCK = 64
"""Images in memory at once."""


@dataclass(frozen=True)
class _Origin:
    """A store to merge, with its tables, which are read once."""

    store: Store
    frames: pa.Table
    trajectories: pa.Table
    findings: pa.Table
    sensors: Mapping[str, Mapping[str, Any]]

    @classmethod
    def of(cls, store: Store) -> _Origin:
        """From a store."""
        return cls(store, store.frames(), store.trajectories(), store.findings(), store.sensors())


@dataclass(frozen=True)
class _Piece:
    """One source of one store: its row there, its first frame and its first trajectory there."""

    origin: _Origin
    row: int
    facts: Mapping[str, Any]
    contents: Mapping[str, Any]
    first_frame: int
    first_trajectory: int

    @property
    def store(self) -> Store:
        """The store that it comes from."""
        return self.origin.store


def merge(sources: Sequence[Store | Path | str], into: Path | str) -> list[Finding]:
    """What is worth saying after stores were merged into a new or existing one, as if all had been ingested there.

    Sources go in the order of the call; one that several stores hold goes in once. Killed and run again, it goes on.
    Memory: one recording's numbers at a time, images in blocks.

    Parameters
    ----------
    sources : list of stores, paths or URLs
    into : Path
        A local store, made where there is none (with the first store's sizes of chunks).

    Raises
    ------
    StoreError
        An image of a source store is damaged and not marked as broken.
    """
    stores = [one if isinstance(one, Store) else Store.open(one) for one in sources]
    if not stores:
        raise UsageError("no store to merge", "one store or more")
    target = Path(into)
    if any(Path(store.location).resolve() == target.resolve() for store in stores):
        raise UsageError(f"{into} is merged into itself", "another store to write into", "Name a new store.")
    if not (target / MANIFEST).exists():
        create(target, settings_of(stores[0].manifest))
    with writing_lock(target, INTAKE_LOCK):
        recover(target)
        return _merge(stores, target)


def _merge(stores: Sequence[Store], target: Path) -> list[Finding]:
    n_before = len(Store.open(target).findings())
    findings: list[Finding] = []
    pieces = _plan([_Origin.of(store) for store in stores], Store.open(target), findings)
    starts = _starts(Store.open(target), pieces)
    commit_groups(target, (_staged(target, piece, starts) for piece in pieces))
    _carry_sensors(stores, target)
    for store in stores:
        if names := store.split_names():
            listed = ", ".join(names)
            message = f"splits of {store.location} were not copied ({listed}): they belong to that store; split anew"
            findings.append(Finding("merge-split", "info", message, count=len(names)))
    return [*findings, *_new_conflicts(Store.open(target), n_before)]


def _carry_sensors(stores: Sequence[Store], target: Path) -> None:
    """Sensors that were added by hand, which no recording carries."""
    for store in stores:
        known = Store.open(target).manifest
        facts, references = store.sensors(), store.manifest["references"]
        names = sorted({*facts, *references} - {*known["sensors"], *known["references"]})
        if names:
            pictures = {name: store.reference(name) for name in names if name in references}
            keep_sensors(target, {name: facts.get(name, {}) for name in names}, pictures)


def _pieces(origin: _Origin) -> Iterator[_Piece]:
    frame = trajectory = 0
    for row, facts in enumerate(origin.store.sources().to_pylist()):
        yield _Piece(origin, row, facts, json.loads(facts["contents"]), frame, trajectory)
        frame, trajectory = frame + facts["frames"], trajectory + facts["trajectories"]


def _plan(origins: Sequence[_Origin], target: Store, findings: list[Finding]) -> list[_Piece]:
    """The sources that the target does not hold yet, each once, in order."""
    held, chosen, twice = set(target.manifest["sources"]), [], 0
    for origin in origins:
        for piece in _pieces(origin):
            if piece.facts["sha256"] in held:
                twice += 1
                continue
            held.add(piece.facts["sha256"])
            chosen.append(piece)
    if twice:
        message = f"{twice} recordings are in more than one of the stores (or in the target already); each is kept once"
        findings.append(Finding("merge-twice", "info", message, count=twice))
    return chosen


def _starts(target: Store, pieces: Sequence[_Piece]) -> dict[str, int]:
    """First frame of each source in the merged store."""
    starts, row = {}, 0
    for source in target.sources(["sha256", "frames"]).to_pylist():
        starts[source["sha256"]] = row
        row += source["frames"]
    for piece in pieces:
        starts[piece.facts["sha256"]] = row
        row += piece.facts["frames"]
    return starts


def _new_conflicts(target: Store, n_before: int) -> list[Finding]:
    rows = target.findings().slice(n_before).to_pylist()
    wanted = ("sensor-conflict", "signal-variant")
    return [
        Finding(row["code"], row["severity"], row["message"], row["stream"]) for row in rows if row["code"] in wanted
    ]


def _staged(target: Path, piece: _Piece, starts: Mapping[str, int]) -> StagedTake:
    sha256 = piece.facts["sha256"]
    largest = settings_of(piece.store.manifest).heap_chunk_bytes
    with Spool(staging_folder(target, sha256), largest) as spool:
        frames, lost = _frames(piece, spool, starts)
        take = Take(
            source=Source(piece.facts["key"], piece.facts["key"], piece.facts["format"], ()),
            sha256=sha256,
            status=piece.facts["status"],
            description=json.loads(piece.facts["description"]),
            provenance=json.loads(piece.facts["provenance"]),
            frames=frames,
            trajectories=_trajectories(piece),
            findings=_rows_of(piece.origin.findings, piece.row),
            signals={facts["name"]: _signal(piece, name, facts) for name, facts in piece.contents["signals"].items()},
            aligned={facts["name"]: _aligned(piece, name, facts) for name, facts in piece.contents["aligned"].items()},
            references={sensor: piece.store.reference(sensor) for sensor in piece.contents["references"]},
            sensors={
                sensor: facts for sensor, facts in piece.origin.sensors.items() if sensor in piece.contents["sensors"]
            },
            frame_values={
                facts["name"]: _frame_values(piece, name, facts)
                for name, facts in piece.contents["frame_values"].items()
            },
        )
        return stage(target, spool, take, None if lost else piece.contents["content"])


def _rows_of(table: pa.Table, source: int) -> pa.Table:
    """Rows of a source, which are side by side, as rows of source 0."""
    start, stop = np.searchsorted(np.asarray(table["source"]), [source, source + 1]).tolist()
    rows = table.slice(start, stop - start)
    return rows.set_column(rows.schema.get_field_index("source"), "source", pa.array(np.zeros(len(rows)), pa.int32()))


def _frames(piece: _Piece, spool: Spool, starts: Mapping[str, int]) -> tuple[pa.Table, bool]:
    """The frames table of the take, payloads in the spool; whether any image was lost."""
    table = piece.origin.frames.slice(piece.first_frame, piece.facts["frames"])
    rows = table.select(["camera", "encoding", "height", "width", "crc32c", "flags"]).to_pylist()
    lost = False
    for first in range(0, len(rows), BLOCK):
        for row, frame in enumerate(rows[first : first + BLOCK], start=first):
            payload = _payload(piece, piece.first_frame + row, frame)
            encoding: Encoding = "missing" if payload is None else frame["encoding"]
            lost |= encoding != frame["encoding"]
            spool.add(Image(frame["camera"], payload or b"", encoding, frame["height"], frame["width"], log_ns=-1))
    spooled = spool.columns()
    trajectory = np.asarray(table["trajectory"])
    gone = np.array([payload == "missing" for payload in spooled["encoding"].to_pylist()], dtype=bool)
    changed: dict[str, Any] = {
        "trajectory": pa.array(np.where(trajectory < 0, -1, trajectory - piece.first_trajectory)),
        "source": pa.array(np.zeros(len(table))),
        "parent_frame": pa.array(_parents(piece, np.asarray(table["parent_frame"]), starts)),
        "flags": pa.array(np.asarray(table["flags"]) | np.where(gone, FrameFlag.MISSING, 0).astype(np.uint32)),
        **{name: spooled[name] for name in ("offset", "length", "crc32c", "encoding")},
    }
    columns = [changed.get(field.name, table[field.name]).cast(field.type) for field in FRAME_SCHEMA]
    return pa.table(columns, schema=FRAME_SCHEMA), lost


def _payload(piece: _Piece, row: int, frame: Mapping[str, Any]) -> bytes | None:
    """An image's bytes; ``None`` where there are none, or none that can be read and the store says so."""
    broken = bool(frame["flags"] & FrameFlag.BROKEN)
    try:
        return piece.store.encoded([row], verify=not broken)[0]
    except StoreError as error:
        if broken:
            return None
        raise StoreError(
            f"{error.found}, in {piece.store.location}",
            "a store that `tactiledata check` passes",
            "Run `tactiledata check --repair` on it, which marks damaged images, then merge again.",
            row=row,
        ) from error


def _parents(piece: _Piece, parents: NDArray[np.int64], starts: Mapping[str, int]) -> NDArray[np.int64]:
    """Row numbers of parents in the merged store."""
    if (parents < 0).all():
        return parents
    others = list(_pieces(piece.origin))
    firsts = np.array([other.first_frame for other in others])
    new = np.array([starts[other.facts["sha256"]] for other in others])
    of = np.searchsorted(firsts, np.maximum(parents, 0), side="right") - 1
    return np.where(parents < 0, -1, parents - firsts[of] + new[of])


def _trajectories(piece: _Piece) -> pa.Table:
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


def _signal(piece: _Piece, stored: str, facts: Mapping[str, Any]) -> StoredSignal:
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


def _aligned(piece: _Piece, stored: str, facts: Mapping[str, Any]) -> AlignedSignal:
    meaning = piece.store.meaning("aligned", stored)
    values, gap_ns = piece.store.aligned(stored, _frame_rows(piece))
    method = facts["attributes"]["method"]
    return AlignedSignal(values, gap_ns, meaning.columns, meaning.units, meaning.frame, method)


def _frame_values(piece: _Piece, stored: str, facts: Mapping[str, Any]) -> FrameValues:
    meaning = piece.store.meaning("frame_values", stored)
    values = piece.store.frame_values(stored, _frame_rows(piece))
    return FrameValues(values, meaning.columns, meaning.units, facts["attributes"]["note"])


def _frame_rows(piece: _Piece) -> NDArray[np.int64]:
    return np.arange(piece.first_frame, piece.first_frame + piece.facts["frames"])
