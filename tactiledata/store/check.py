"""Whether a store is whole: manifest, files, arrays, tables, payloads, and what does not belong to it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import google_crc32c
import numpy as np

from tactiledata.contract.provenance import digest_of
from tactiledata.contract.records import Finding
from tactiledata.contract.schema import check_document
from tactiledata.contract.take import FrameFlag
from tactiledata.errors import SchemaError, TactileDataError
from tactiledata.store.index_checks import index_findings
from tactiledata.store.layout import (
    ALIGNED_ARRAYS,
    SIGNAL_ARRAYS,
    aligned_path,
    frame_values_path,
    home_of,
    signal_path,
    table_folder,
)
from tactiledata.store.payload_checks import payload_faults
from tactiledata.store.reader import Store
from tactiledata.store.recover import (
    foreign_arrays,
    foreign_parts,
    heaps,
    is_interrupted,
    raw_arrays,
    row_arrays,
    stale_staging,
    temporary_files,
)
from tactiledata.store.rows import Rows
from tactiledata.store.sensors_table import image_crc

BLOCK_ROWS = 65_536


def check(
    store: Store | Path | str, images: bool = True, decode: bool = False, threads: int | None = None
) -> list[Finding]:
    """What is wrong with a store; empty where nothing is.

    Parameters
    ----------
    images : bool
        Whether every image is held against its CRC-32C.
    decode : bool
        Whether every image is decoded as well.
    threads : int, optional
        Threads that check images; one a core by default.

    Raises
    ------
    MissingFile, StoreError
        It cannot even be opened.
    """
    opened = store if isinstance(store, Store) else Store.open(store)
    findings = [*_manifest_findings(opened)]
    broken_parts = list(_part_findings(opened))
    findings += [*broken_parts, *_shape_findings(opened), *_sensor_findings(opened)]
    if not broken_parts:
        findings += index_findings(opened)
        findings += _value_findings(opened)
        findings += image_findings(opened, decode, threads) if images else []
    return [*findings, *_leftover_findings(opened)]


def _damage(code: str, message: str, stream: str = "", count: int = 1) -> Finding:
    return Finding(code, "damage", message, stream=stream, count=count)


def _manifest_findings(store: Store) -> Iterator[Finding]:
    try:
        check_document(store.manifest, "store", "manifest.json")
    except SchemaError as error:
        yield _damage("store-manifest", str(error))
        return
    rows = store.manifest["rows"]
    for table, parts in store.manifest["index"].items():
        total = sum(part["rows"] for part in parts)
        if total != rows[table]:
            yield _damage("store-manifest", f"the parts of {table} have {total} rows, the manifest says {rows[table]}")
    if len(store.manifest["sources"]) != rows["sources"]:
        yield _damage("store-manifest", f"{len(store.manifest['sources'])} digests for {rows['sources']} sources")
    for kind in ("aligned", "frame_values"):
        for name, facts in store.manifest[kind].items():
            if facts["rows"] != rows["frames"]:
                yield _damage("store-manifest", f"{kind} {name!r} has {facts['rows']} rows for {rows['frames']} frames")


def _part_findings(store: Store) -> Iterator[Finding]:
    for table, parts in store.manifest["index"].items():
        for part in parts:
            path = f"{table_folder(table)}/{part['file']}"
            try:
                digest = hashlib.sha256(store.read_file(path)).hexdigest()
            except (TactileDataError, OSError) as error:
                yield _damage("store-part", f"{path} cannot be read: {error}", table)
                continue
            if digest != part["sha256"]:
                yield _damage(
                    "store-part", f"{path} is not the file that the manifest names (SHA-256 {digest[:12]}…)", table
                )


def _shape_findings(store: Store) -> Iterator[Finding]:
    """Arrays that are missing or shorter than the manifest says."""
    wanted = [*row_arrays(store.manifest), *heaps(store.manifest)]
    wanted += [(path, count) for path, _, count in raw_arrays(store.manifest)]
    for path, length in wanted:
        try:
            shape = store.array(path).shape
        except (TactileDataError, OSError, ValueError, KeyError) as error:
            yield _damage("store-array", f"array {path} cannot be opened: {error}", path)
            continue
        if shape[0] < length:
            yield _damage("store-array", f"array {path} has {shape[0]} rows, the manifest names {length}", path)


def _sensor_findings(store: Store) -> Iterator[Finding]:
    try:
        for sensor, facts in store.sensors().items():
            if digest_of(facts) != store.manifest["sensors"][sensor]:
                yield _damage("store-sensors", f"the facts of sensor {sensor} are not those of the manifest", sensor)
    except TactileDataError as error:
        yield _damage("store-sensors", str(error))
    for sensor, crc in store.manifest["references"].items():
        try:
            image = store.reference(sensor).image
        except (TactileDataError, OSError, ValueError, KeyError) as error:
            yield _damage("store-reference", f"the picture of {sensor} without contact cannot be read: {error}", sensor)
            continue
        if image_crc(image) != crc:
            yield _damage(
                "store-reference", f"the picture of {sensor} without contact does not fit its CRC-32C", sensor
            )


def _value_findings(store: Store) -> Iterator[Finding]:
    """Numbers that are not those of their sources, and times that run backwards."""
    first_frame = 0
    rows: dict[str, Rows] = {}
    for source in store.sources(["key", "frames", "contents"]).to_pylist():
        contents: dict[str, Any] = json.loads(source["contents"])
        frames = (first_frame, first_frame + source["frames"])
        first_frame = frames[1]
        for path, start, stop, crc in _spans(home_of(store.manifest), contents, frames):
            fault = _span_fault(store, rows, path, start, stop, crc)
            if fault:
                yield _damage("store-values", f"{path}, rows {start} to {stop} of {source['key']}: {fault}", path)


def _spans(home: str, contents: dict[str, Any], frames: tuple[int, int]) -> Iterator[tuple[str, int, int, int]]:
    for name, facts in contents.get("signals", {}).items():
        yield from ((signal_path(home, name, array), *facts["rows"], facts["crc32c"][array]) for array in SIGNAL_ARRAYS)
    for name, facts in contents.get("aligned", {}).items():
        yield from ((aligned_path(home, name, array), *frames, facts["crc32c"][array]) for array in ALIGNED_ARRAYS)
    for name, facts in contents.get("frame_values", {}).items():
        yield frame_values_path(home, name), *frames, facts["crc32c"]["value"]


def _span_fault(store: Store, rows: dict[str, Rows], path: str, start: int, stop: int, expected: int) -> str:
    values = rows.setdefault(path, store.rows(path, max(stop, rows[path].length if path in rows else 0)))
    if values.length < stop:
        values = rows[path] = store.rows(path, stop)
    crc, last = 0, None
    try:
        for first in range(start, stop, BLOCK_ROWS):
            block = values.span(first, min(first + BLOCK_ROWS, stop))
            crc = google_crc32c.extend(crc, np.ascontiguousarray(block).tobytes())
            if path.endswith("/t_ns"):
                if (np.diff(block) < 0).any() or (last is not None and block[0] < last):
                    return "times run backwards"
                last = block[-1]
    except (TactileDataError, OSError) as error:
        return str(error)
    return "" if crc == expected else "the numbers do not fit their CRC-32C"


def image_findings(store: Store, decode: bool, threads: int | None) -> list[Finding]:
    """Findings for damaged images: those that the store does not mark yet, and those that it does."""
    try:
        flags = np.asarray(store.frames(["flags"])["flags"])
        faults = list(payload_faults(store, decode, threads))
    except TactileDataError as error:
        return [_damage("store-payload", str(error))]
    new = [(row, why) for row, why in faults if not flags[row] & FrameFlag.BROKEN]
    marked = len(faults) - len(new)
    findings = []
    if new:
        shown = "; ".join(f"frame {row}: {why}" for row, why in new[:5]) + ("; …" if len(new) > 5 else "")
        message = f"{len(new)} images are damaged ({shown}); `check --repair` marks them as broken"
        findings.append(_damage("store-payload", message, count=len(new)))
    if marked:
        message = f"{marked} images are damaged and marked as broken"
        findings.append(Finding("store-payload-marked", "warning", message, count=marked))
    return findings


def _leftover_findings(store: Store) -> Iterator[Finding]:
    place = Path(store.location)
    if not place.is_dir():
        return
    leftovers = [*foreign_arrays(place, store.manifest), *foreign_parts(place, store.manifest), *temporary_files(place)]
    leftovers += stale_staging(place, store.manifest)
    if leftovers or is_interrupted(place):
        shown = ", ".join(str(one.relative_to(place)) for one in leftovers[:5]) + (" …" if len(leftovers) > 5 else "")
        message = (
            f"a writer was interrupted and left {shown or 'unfinished appends'}; harmless, the next write removes it"
        )
        yield Finding("store-leftover", "info", message, count=max(1, len(leftovers)))
