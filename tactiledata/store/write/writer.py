"""Staged takes: a source turned into files that wait for their commit, a marker written last."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import google_crc32c
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from tactiledata.contract.arrow_memory import read_parquet
from tactiledata.contract.provenance import file_digest, json_bytes
from tactiledata.contract.records import Stamps
from tactiledata.contract.take import Take
from tactiledata.store.layout.images import damaged_spool
from tactiledata.store.layout.lock import unwritable
from tactiledata.store.layout.places import STAGING, TABLE_SCHEMAS, staging_folder
from tactiledata.store.write.spool import Spool
from tactiledata.store.write.take_checks import check_take

__all__ = ["StagedTake", "find_staged", "stage", "staging_folder"]

MARKER = "take.json"
ARRAYS = "arrays.bin"
STAGED_TABLES = ("frames", "trajectories", "findings")


@dataclass(frozen=True)
class StagedTake:
    """A take on disk, ready to be committed.

    Parameters
    ----------
    folder : Path
    sha256 : str
        Digest of the source.
    n_frames, n_bytes : int
        What decides the borders of commit groups.
    document : dict
        Content of the marker: all of the take that is neither a table nor an array.
    is_placed : bool
        Whether its images lie in the store already, where its frames say.
    """

    folder: Path
    sha256: str
    n_frames: int
    n_bytes: int
    document: Mapping[str, Any]
    is_placed: bool = False

    def renamed(self, key: str) -> StagedTake:
        """The take under another name of its recording."""
        return dataclasses.replace(self, document={**self.document, "key": key})

    def table(self, name: str) -> pa.Table:
        """``frames``, ``trajectories`` or ``findings``, rows local to the take."""
        return read_parquet(self.folder / f"{name}.parquet", TABLE_SCHEMAS[name])

    def array(self, entry: Mapping[str, Any]) -> NDArray[Any]:
        """An array that the document describes, mapped from the disk."""
        if not np.prod(entry["shape"]):
            return np.empty(entry["shape"], entry["dtype"])
        return np.memmap(self.folder / ARRAYS, entry["dtype"], "r", entry["offset"], tuple(entry["shape"]))

    def check(self) -> None:
        """Refuse a staged take whose tables or arrays are not what was staged.

        Raises
        ------
        StoreError
            They are not: the disk lost something.
        """
        for name, digest in self.document["tables"].items():
            place = self.folder / f"{name}.parquet"
            if not place.is_file() or file_digest(place) != digest:
                raise damaged_spool(place)
        for kind in ("signals", "aligned", "frame_values", "references"):
            for entry in self.document[kind].values():
                for array in entry["arrays"].values():
                    self._check_array(array)

    def _check_array(self, entry: Mapping[str, Any]) -> None:
        crc = 0
        try:
            for block in _blocks(self.array(entry)):
                crc = google_crc32c.extend(crc, block.tobytes())
        except (OSError, ValueError) as error:
            raise damaged_spool(self.folder / ARRAYS) from error
        if crc != entry["crc32c"]:
            raise damaged_spool(self.folder / ARRAYS)


def stage(store_path: Path | str, spool: Spool, take: Take, content: str | None = None) -> StagedTake:
    """A take as files under the store's staging folder; the marker is written last.

    Nothing is synced here, which would cost more than all the rest where recordings are small: a commit checks what it
    takes, and a take that a power cut damaged is read again from its recording.

    Parameters
    ----------
    store_path : Path
        A store, or where one will be.
    spool : Spool
        Where the take's images went; its files are moved (best it was made in ``staging_folder(store_path, sha256)``).
    take : Take
    content : str, optional
        Digest of the take's content, where it is known already (merging); computed otherwise.

    Raises
    ------
    StoreError
        The take does not fit together, or the disk is full.
    """
    check_take(take, len(spool))
    folder = staging_folder(store_path, take.sha256)
    try:
        spool.close()
        if spool.folder != folder:
            shutil.rmtree(folder, ignore_errors=True)
            folder.parent.mkdir(parents=True, exist_ok=True)
            shutil.move(spool.folder, folder)
        return _write(folder, take, content)
    except OSError as error:
        raise unwritable(store_path, error) from error


def stage_placed(store_path: Path | str, take: Take, content: str) -> StagedTake:
    """A take whose images lie in the store already: its frames' ``offset`` and ``length`` are those of the store.

    Parameters
    ----------
    store_path : Path or str
        Folder of the store.
    take : Take
        The take, whose frames' ``offset`` and ``length`` are those of the store.
    content : str
        Digest of what was recorded, as the table of sources keeps it.

    Raises
    ------
    StoreError
        The take is not whole, or the staging folder cannot be written.
    """
    check_take(take, len(take.frames))
    folder = staging_folder(store_path, take.sha256)
    try:
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        return _write(folder, take, content, is_placed=True)
    except OSError as error:
        raise unwritable(store_path, error) from error


def _write(folder: Path, take: Take, content: str | None, is_placed: bool = False) -> StagedTake:
    spool_bytes = sum(place.stat().st_size for place in folder.iterdir())
    for name in STAGED_TABLES:
        table = getattr(take, name).cast(TABLE_SCHEMAS[name])
        pq.write_table(table, folder / f"{name}.parquet", compression="lz4")
    with (folder / ARRAYS).open("wb") as stream:
        document = _document(take, _Arrays(stream))
    document["n_bytes"] = spool_bytes + (folder / ARRAYS).stat().st_size
    document["content"] = content or content_digest(take, document)
    document["tables"] = {name: file_digest(folder / f"{name}.parquet") for name in STAGED_TABLES}
    content_of_marker = json_bytes(document)
    (folder / f"{MARKER}.part").write_bytes(content_of_marker)
    (folder / f"{MARKER}.part").replace(folder / MARKER)
    # as one who finds it after a kill reads it: the order of its keys reaches the store's files
    return _staged(folder, json.loads(content_of_marker), is_placed)


def find_staged(store_path: Path | str) -> dict[str, StagedTake]:
    """Takes that are staged whole, by the digest of their source."""
    folders = sorted((Path(store_path) / STAGING).glob("*/" + MARKER))
    found = {}
    for marker in folders:
        try:
            document = json.loads(marker.read_bytes())
            found[document["sha256"]] = _staged(marker.parent, document)
        except (ValueError, KeyError):
            continue  # not whole: `recover` drops it
    return {sha256: staged for sha256, staged in found.items() if staged.folder.name == sha256}


def _staged(folder: Path, document: Mapping[str, Any], is_placed: bool = False) -> StagedTake:
    return StagedTake(folder, document["sha256"], document["n_frames"], document["n_bytes"], document, is_placed)


class _Arrays:
    """One file of arrays, one after another: a file each would cost a sync each."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def add(self, values: NDArray[Any], dtype: str) -> dict[str, Any]:
        """The entry that finds the array again, with its CRC-32C."""
        self._stream.write(b"\0" * (-self._stream.tell() % 16))
        entry: dict[str, Any] = {"offset": self._stream.tell(), "dtype": dtype, "shape": list(values.shape)}
        crc = 0
        for block in _blocks(values):
            content = np.ascontiguousarray(block, dtype=dtype).tobytes()
            crc = google_crc32c.extend(crc, content)
            self._stream.write(content)
        return {**entry, "crc32c": crc}


def _blocks(values: NDArray[Any], rows: int = 65_536) -> Iterator[NDArray[Any]]:
    for start in range(0, len(values), rows):
        yield values[start : start + rows]


def _document(take: Take, arrays: _Arrays) -> dict[str, Any]:
    source = take.source
    return {
        "sha256": take.sha256,
        "key": source.key,
        "format": source.format,
        "status": take.status,
        "description": dict(take.description),
        "provenance": dict(take.provenance),
        "n_frames": len(take.frames),
        "n_trajectories": len(take.trajectories),
        "signals": {
            name: {
                **_facts(signal),
                "attributes": dict(signal.attributes),
                "arrays": {
                    "t_ns": arrays.add(signal.t_ns, "<i8"),
                    "value": arrays.add(signal.values, "<f8"),
                    **{
                        f"{kind}_ns": arrays.add(_stamp(signal.stamps, kind), "<i8")
                        for kind in ("log", "publish", "header")
                    },
                },
            }
            for name, signal in sorted(take.signals.items())
        },
        "aligned": {
            name: {
                **_facts(signal),
                "attributes": {"method": signal.method},
                "arrays": {"value": arrays.add(signal.values, "<f8"), "gap_ns": arrays.add(signal.gap_ns, "<i8")},
            }
            for name, signal in sorted(take.aligned.items())
        },
        "frame_values": {
            name: {
                "columns": list(values.columns),
                "units": list(values.units),
                "frame": "",
                "attributes": {"note": values.note},
                "arrays": {"value": arrays.add(values.values, "<f8")},
            }
            for name, values in sorted(take.frame_values.items())
        },
        "references": {
            sensor: {
                "attributes": {"origin": reference.origin, "licence": reference.licence, "model": reference.model},
                "arrays": {"image": arrays.add(reference.image, "|u1")},
            }
            for sensor, reference in sorted(take.references.items())
        },
        "sensors": {sensor: dict(facts) for sensor, facts in sorted(take.sensors.items())},
    }


def _facts(signal: Any) -> dict[str, Any]:
    return {"columns": list(signal.columns), "units": list(signal.units), "frame": signal.frame}


def _stamp(stamps: Stamps, kind: str) -> NDArray[np.int64]:
    values = getattr(stamps, kind)
    return np.full(len(stamps), -1, dtype=np.int64) if values is None else values


PLACE_COLUMNS = ("source", "offset", "length", "parent_frame")
"""Columns of frames that say where something lies, not what it is."""


def content_digest(take: Take, document: Mapping[str, Any]) -> str:
    """SHA-256 of what a take holds, wherever its bytes lie: the same when it is staged from another store."""
    total = hashlib.sha256()
    what = {name: value for name, value in document.items() if name not in ("n_bytes", "content", "tables")}
    total.update(json_bytes(json.loads(json_bytes(what), object_hook=_without_offset)))
    for name in STAGED_TABLES:
        schema = TABLE_SCHEMAS[name]
        table: pa.Table = getattr(take, name).cast(schema).combine_chunks()
        for column in schema.names:
            if column not in PLACE_COLUMNS:
                total.update(f"\n{name}.{column}\n".encode() + _column_bytes(table[column]))
    return total.hexdigest()


def _without_offset(entry: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in entry.items() if not (key == "offset" and "dtype" in entry)}


def _column_bytes(column: pa.ChunkedArray) -> bytes:
    if pa.types.is_dictionary(column.type):
        column = column.cast(pa.string())
    if pa.types.is_string(column.type):
        return json_bytes(column.to_pylist())
    return column.is_null().to_numpy().tobytes() + column.fill_null(0).to_numpy().tobytes()
