"""What of a damaged store can be mended without inventing data."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa

from tactiledata.contract.arrow_memory import read_parquet
from tactiledata.contract.progress import Progress
from tactiledata.contract.provenance import digest_of
from tactiledata.contract.records import Finding
from tactiledata.contract.take import FrameFlag
from tactiledata.contract.wording import counted
from tactiledata.errors import SchemaError
from tactiledata.store.check.check import check, manifest_findings
from tactiledata.store.check.payloads import payload_faults
from tactiledata.store.check.pointers import need_no_pointers
from tactiledata.store.check.tables import table_findings
from tactiledata.store.layout.arrays import set_length
from tactiledata.store.layout.batch import Batch
from tactiledata.store.layout.lock import writing_lock
from tactiledata.store.layout.made_splits import made_names, names_on_disk, write_names
from tactiledata.store.layout.manifest import Manifest, extended_digest, read_manifest, settings_of, write_manifest
from tactiledata.store.layout.places import INTAKE_LOCK, MADE_SPLITS, MANIFEST, TABLE_SCHEMAS, table_folder
from tactiledata.store.read.reader import Store
from tactiledata.store.write.appender import write_part
from tactiledata.store.write.commit import record_anew, recover, refresh_card, store_errors
from tactiledata.store.write.recover import heaps, raw_arrays, row_arrays


def repair(store_path: Path | str, decode: bool = False, progress: Progress | None = None) -> list[Finding]:
    """What was mended (``store-mended``), and what `check` still finds.

    Leftovers of killed writers are removed, chunk files and shapes that were cut are stretched again, images that do
    not fit their CRC-32C or are too large to be decoded are marked as broken, the dataset card is written anew. A store
    that was written before there were digests of its documents gets them, where nothing is damaged. Splits that are
    gone with all their files leave the list of splits. Numbers, tables and
    images that are lost stay lost: those findings remain, and the recordings are the place to take them from.

    Parameters
    ----------
    store_path : Path or str
        Folder of the store.
    decode : bool
        Whether every image is decoded, so that those that do not decode are marked too.
    progress : callable, optional
        Told of the check afterwards.

    Raises
    ------
    NotFetched
        Files are Git LFS pointers: what they stand for is not lost.
    """
    folder = Path(store_path)
    read_manifest(folder)
    need_no_pointers(folder)
    with writing_lock(folder, INTAKE_LOCK):
        # what an ingest is staging right now must not be swept away
        recover(folder)
    with store_errors(folder), writing_lock(folder):
        manifest = read_manifest(folder)
        mended = list(_stretch(folder, manifest))
        broken = {table for table, found in table_findings(Store.open(folder)).items() if found}
        if "frames" not in broken:
            mended += _mark_broken(folder, manifest, decode)
        if not broken and not list(manifest_findings(manifest)):
            refresh_card(folder, manifest)
        mended += _splits_listed(folder)
    findings = check(folder, decode=decode, progress=progress)
    if "documents" not in manifest and not any(finding.severity == "damage" for finding in findings):
        mended.append(_recorded(folder))
        findings = [finding for finding in findings if (finding.code, finding.stream) != ("store-no-digest", MANIFEST)]
    return [*mended, *findings]


def _splits_listed(folder: Path) -> list[Finding]:
    """The list of splits names those that are there; a store without a list needs none."""
    place = folder / MADE_SPLITS
    if not place.is_file():
        return []
    try:
        listed = made_names(place.read_bytes())
    except SchemaError:
        write_names(folder, names_on_disk(folder))
        return [_mended(f"{MADE_SPLITS} was written anew")]
    files = {one.name for one in (folder / "splits").glob("*")}
    gone = [name for name in listed if not {f"{name}.json", f"{name}.parquet"} & files]
    if not gone:
        return []
    write_names(folder, sorted({*listed} - {*gone}))
    return [
        _mended(f"{counted(len(gone), 'split')} that are gone left the list of splits: {', '.join(gone)}", len(gone))
    ]


def _recorded(folder: Path) -> Finding:
    with store_errors(folder), writing_lock(folder):
        manifest = read_manifest(folder)
        record_anew(folder, manifest)
    return _mended(f"the digests of {len(manifest['documents'])} documents were recorded", len(manifest["documents"]))


def _mended(message: str, count: int = 1) -> Finding:
    return Finding("store-mended", "info", message, count=count)


def _stretch(folder: Path, manifest: Manifest) -> Iterator[Finding]:
    """Chunk files of their nominal size, shapes that cover the manifest's lengths."""
    chunk = settings_of(manifest).heap_chunk_bytes
    for path, used in heaps(manifest):
        for index in range(-(-used // chunk)):
            place = folder / path / f"c.{index}"
            if place.is_file() and place.stat().st_size != chunk:
                yield _mended(f"{path}/c.{index} had {place.stat().st_size} bytes, stretched to {chunk}")
                os.truncate(place, chunk)
    wanted = [*row_arrays(manifest), *heaps(manifest), *((path, count) for path, _, count in raw_arrays(manifest))]
    with Batch(folder) as batch:
        for path, length in wanted:
            try:
                shape = json.loads(batch.read(f"{path}/zarr.json"))["shape"]
            except (OSError, ValueError, KeyError, TypeError, RecursionError):
                continue
            if shape[0] != length:
                yield _mended(f"array {path} said {shape[0]} rows, set to {length}")
                set_length(batch, path, length)
        batch.publish()


def _mark_broken(folder: Path, manifest: Manifest, decode: bool) -> list[Finding]:
    """Frames whose payload is damaged get the flag BROKEN: their parts are written anew, then the manifest."""
    store = Store.open(folder)
    flags = np.asarray(store.frames(["flags"])["flags"])
    bad = [row for row, _ in payload_faults(store, decode) if not flags[row] & FrameFlag.BROKEN]
    if not bad:
        return []
    rows = np.array(bad)
    first, replaced = 0, []
    with Batch(folder) as batch:
        for index, part in enumerate(manifest["index"]["frames"]):
            mine = rows[(rows >= first) & (rows < first + part["rows"])] - first
            first += part["rows"]
            if len(mine):
                replaced.append(folder / table_folder("frames") / part["file"])
                changed = write_part(batch, "frames", _next_name(part["file"]), _flagged(replaced[-1], mine))
                manifest["index"]["frames"][index] = changed
        batch.publish()
    manifest["digest"] = extended_digest(manifest["digest"], f"broken {digest_of(bad)}")
    write_manifest(folder, manifest)
    for place in replaced:
        place.unlink()
    return [_mended(f"{counted(len(bad), 'image')} marked as broken: damaged, or too large to be decoded", len(bad))]


def _next_name(file: str) -> str:
    stem, _, suffix = file.removesuffix(".parquet").removeprefix("part-").partition("-")
    return f"part-{stem}-{int(suffix or 0) + 1}.parquet"


def _flagged(place: Path, rows: np.ndarray) -> pa.Table:
    table = read_parquet(place, TABLE_SCHEMAS["frames"])
    flags = table["flags"].to_numpy().copy()
    flags[rows] |= FrameFlag.BROKEN
    index = table.schema.get_field_index("flags")
    return table.set_column(index, table.schema.field(index), pa.array(flags, pa.uint32()))
