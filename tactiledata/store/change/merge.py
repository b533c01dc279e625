"""Stores merged into one: each source becomes a take again and is committed as if it had been ingested there."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from tactiledata.contract.progress import Progress
from tactiledata.contract.records import Encoding, Finding, Image
from tactiledata.contract.take import FRAME_SCHEMA, FrameFlag, Take
from tactiledata.contract.wording import agreeing, counted, listed
from tactiledata.errors import StoreError, UsageError
from tactiledata.store.change.flag import carry_flags
from tactiledata.store.change.keep_sensors import BY_HAND, keep_sensors
from tactiledata.store.change.pieces import Origin, Piece, parents, pieces_of, rows_of, take_of
from tactiledata.store.layout.lock import writing_lock
from tactiledata.store.layout.manifest import settings_of
from tactiledata.store.layout.places import INTAKE_LOCK, MANIFEST, staging_folder
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import commit_groups, create, recover
from tactiledata.store.write.spool import Spool
from tactiledata.store.write.writer import StagedTake, stage

BLOCK = 64
"""Images in memory at once."""


def merge(
    sources: Sequence[Store | Path | str],
    into: Path | str,
    progress: Progress | None = None,
    change: Callable[[Take], Take] | None = None,
) -> list[Finding]:
    """What is worth saying after stores were merged into a new or existing one, as if all had been ingested there.

    Sources go in the order of the call; one that several stores hold goes in once. Flags of trajectories go along.
    Killed and run again, it goes on.
    Memory: one recording's numbers at a time, images in blocks.

    Parameters
    ----------
    sources : list of stores, paths or URLs
    into : Path
        A local store, made where there is none (with the first store's sizes of chunks).
    progress : callable, optional
        Called with how many recordings are done, how many there are, and the name of the last one.
    change : callable, optional
        Changes each recording before it is written; its frames stay as many as they are.

    Raises
    ------
    StoreError
        An image of a source store is damaged and not marked as broken; or its documents, numbers or pictures without
        contact are not those that came.
    """
    stores = [one if isinstance(one, Store) else Store.open(one) for one in sources]
    if not stores:
        raise UsageError("no store to merge", "one store or more")
    target = Path(into)
    if any(Path(store.location).resolve() == target.resolve() for store in stores):
        raise UsageError(f"{into} is merged into itself", "another store to write into", "Name a new store.")
    origins = [Origin.of(store) for store in stores]
    if not (target / MANIFEST).exists():
        create(target, settings_of(stores[0].manifest))
    with writing_lock(target, INTAKE_LOCK):
        recover(target)
        return _merge(origins, target, progress, change)


def _merge(
    origins: Sequence[Origin], target: Path, progress: Progress | None, change: Callable[[Take], Take] | None
) -> list[Finding]:
    n_before = len(Store.open(target).findings())
    findings: list[Finding] = []
    pieces = _plan(origins, Store.open(target), findings)
    starts = _starts(Store.open(target), pieces)

    def takes() -> Iterator[StagedTake]:
        for done, piece in enumerate(pieces, start=1):
            yield _staged(target, piece, starts, change)
            if progress is not None:
                progress(done, len(pieces), piece.facts["key"])

    # before the recordings, so that a kill leaves no flagged trajectory there without its flag
    findings += carry_flags([origin.store for origin in origins], target)
    commit_groups(target, takes())
    _carry_sensors(origins, target)
    # a store that is named twice is told of once
    for store in {origin.store.location: origin.store for origin in origins}.values():
        if names := store.split_names():
            listed = ", ".join(names)
            message = f"splits of {store.location} were not copied ({listed}): they belong to that store; split anew"
            findings.append(Finding("merge-split", "info", message, count=len(names)))
        if meshes := store.mesh_names:
            message = f"meshes of {store.location} were not copied ({', '.join(meshes)}): replay the merged store"
            findings.append(Finding("merge-mesh", "info", message, count=len(meshes)))
    return [*findings, *_new_conflicts(Store.open(target), n_before)]


def _carry_sensors(origins: Sequence[Origin], target: Path) -> None:
    """Keep sensors that were added by hand; one whose recordings were all left out stays behind with them."""
    for origin in origins:
        known, store = Store.open(target).manifest, origin.store
        facts, references = origin.sensors, store.manifest["references"]
        new = sorted({*facts, *references} - {*known["sensors"], *known["references"]})
        if new:
            pictures = {name: store.reference(name) for name in new if name in references}
            contents = store.sources(["contents"])["contents"].to_pylist()
            brought = {
                name for text in contents for kind in ("sensors", "references") for name in json.loads(text)[kind]
            }
            by_hand = {name for name, picture in pictures.items() if picture.origin.startswith(BY_HAND)}
            if names := [name for name in new if name in by_hand or name not in brought]:
                kept = {name: pictures[name] for name in names if name in pictures}
                keep_sensors(target, {name: facts.get(name, {}) for name in names}, kept)


def _plan(origins: Sequence[Origin], target: Store, findings: list[Finding]) -> list[Piece]:
    """The sources that the target does not hold yet, each once, in order."""
    held = {row["sha256"]: _settings(row) for row in target.sources(["sha256", "provenance"]).to_pylist()}
    chosen, twice, otherwise = [], 0, []
    for origin in origins:
        for piece in pieces_of(origin):
            sha256, settings = piece.facts["sha256"], _settings(piece.facts)
            if sha256 in held:
                twice += 1
                otherwise += [] if held[sha256] == settings else [f"{piece.facts['key']} of {piece.store.location}"]
                continue
            held[sha256] = settings
            chosen.append(piece)
    if twice:
        are = f"{counted(twice, 'recording')} {agreeing(twice, 'is', 'are')}"
        message = f"{are} in more than one of the stores (or in the target already), and kept once"
        findings.append(Finding("merge-twice", "info", message, count=twice))
    if otherwise:
        shown = listed(otherwise, 3)
        message = (
            f"{counted(len(otherwise), 'recording')} {agreeing(len(otherwise), 'was', 'were')} ingested with another "
            f"mapping or other options than in the store that came first, which stays as it is ({shown} left out): "
            "forces, sensors and trajectories may differ. Name the store first whose recordings are to stay"
        )
        findings.append(Finding("merge-otherwise", "warning", message, count=len(otherwise)))
    return chosen


def _settings(facts: Mapping[str, Any]) -> str:
    """The digest of the mapping and the options that a source was ingested with, empty where it is not known."""
    return str(json.loads(facts["provenance"] or "{}").get("settings_sha256", ""))


def _starts(target: Store, pieces: Sequence[Piece]) -> dict[str, int]:
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


def _staged(target: Path, piece: Piece, starts: Mapping[str, int], change: Callable[[Take], Take] | None) -> StagedTake:
    sha256 = piece.facts["sha256"]
    largest = settings_of(piece.store.manifest).heap_chunk_bytes
    with Spool(staging_folder(target, sha256), largest) as spool:
        frames, lost = _frames(piece, spool, starts)
        sensors = {name: facts for name, facts in piece.origin.sensors.items() if name in piece.contents["sensors"]}
        take = take_of(piece, frames, rows_of(piece.origin.findings, piece.row), sensors)
        if change is not None:
            return stage(target, spool, change(take))
        return stage(target, spool, take, None if lost else piece.contents["content"])


def _frames(piece: Piece, spool: Spool, starts: Mapping[str, int]) -> tuple[pa.Table, bool]:
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
        "parent_frame": pa.array(parents(piece, np.asarray(table["parent_frame"]), starts)),
        "flags": pa.array(np.asarray(table["flags"]) | np.where(gone, FrameFlag.MISSING, 0).astype(np.uint32)),
        **{name: spooled[name] for name in ("offset", "length", "crc32c", "encoding")},
    }
    columns = [changed.get(field.name, table[field.name]).cast(field.type) for field in FRAME_SCHEMA]
    return pa.table(columns, schema=FRAME_SCHEMA), lost


def _payload(piece: Piece, row: int, frame: Mapping[str, Any]) -> bytes | None:
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
