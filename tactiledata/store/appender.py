"""One group of takes on its way into a store: row numbers made global, arrays appended, tables written as new parts."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
import zarr
from numpy.typing import NDArray

from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.provenance import digest_of, json_bytes
from tactiledata.contract.records import (
    FINDING_SCHEMA,
    FRAME_SCHEMA,
    SOURCE_SCHEMA,
    TRAJECTORY_SCHEMA,
    Finding,
    findings_table,
)
from tactiledata.store.arrays import (
    append_rows,
    create_frames,
    create_heap,
    create_rows,
    open_root,
    set_length,
    write_image,
)
from tactiledata.store.images import HeapAppender, ShardAppender
from tactiledata.store.layout import (
    ALIGNED_ARRAYS,
    SIGNAL_ARRAYS,
    TABLES,
    aligned_path,
    folder_name,
    frame_values_path,
    heap_path,
    part_path,
    reference_path,
    rgb_path,
    signal_path,
    table_folder,
)
from tactiledata.store.manifest import Manifest, extended_digest, settings_of
from tactiledata.store.sensors_table import image_crc, merged_facts, read_sensors, reference_conflict, write_sensors
from tactiledata.store.spool import spool_name
from tactiledata.store.statistics import added, no_statistics
from tactiledata.store.writer import StagedTake

SCHEMAS = {
    "frames": FRAME_SCHEMA,
    "trajectories": TRAJECTORY_SCHEMA,
    "sources": SOURCE_SCHEMA,
    "findings": FINDING_SCHEMA,
}
FILL = {
    "t_ns": ("<i8", -1),
    "log_ns": ("<i8", -1),
    "publish_ns": ("<i8", -1),
    "header_ns": ("<i8", -1),
    "gap_ns": ("<i8", -1),
}
ROW_GROUP = 65_536

Entry = Mapping[str, Any]


class Appender:
    """Appends takes after what a manifest names, and changes that manifest; nothing counts until it is written.

    Parameters
    ----------
    store_path : Path
    manifest : dict
        Changed in place.
    """

    def __init__(self, store_path: Path, manifest: Manifest) -> None:
        self._path = store_path
        self._manifest = manifest
        self._settings = settings_of(manifest)
        self._root = open_root(store_path)
        self._first_frame: int = manifest["rows"]["frames"]
        self._tables: dict[str, list[pa.Table]] = {table: [] for table in TABLES}
        self._pending: dict[tuple[str, str], list[tuple[int, StagedTake, Entry]]] = {}
        self._heaps: dict[str, HeapAppender] = {}
        self._shards: dict[str, ShardAppender] = {}
        self._facts = read_sensors(store_path, manifest)
        self._references: dict[str, NDArray[np.uint8]] = {}

    def add(self, take: StagedTake) -> None:
        """One take: its images appended at once, its rows kept for the new parts, its arrays noted for `finish`."""
        manifest, rows = self._manifest, self._manifest["rows"]
        document = take.document
        findings: list[Finding] = self._add_sensors(take)
        contents: dict[str, Any] = {"content": document["content"], "sensors": sorted(document["sensors"])}
        contents["references"] = sorted(document["references"])
        names: dict[str, str] = {}
        for kind in ("signals", "aligned", "frame_values"):
            contents[kind] = {}
            for name, entry in document[kind].items():
                stored, finding = self._variant(kind, name, entry)
                findings += [finding] if finding else []
                contents[kind][stored] = self._note(kind, stored, take, entry)
                names |= {name: stored} if kind == "signals" else {}
        frames = self._frames(take)
        trajectories = self._trajectories(take, names, contents["signals"])
        table = self._findings(take, findings)
        self._tables["frames"].append(frames)
        self._tables["trajectories"].append(trajectories)
        self._tables["findings"].append(table)
        self._tables["sources"].append(_source_row(document, contents))
        for name, count in (
            ("frames", len(frames)),
            ("trajectories", len(trajectories)),
            ("findings", len(table)),
            ("sources", 1),
        ):
            rows[name] += count
        for name, entry in document["signals"].items():
            manifest["signals"][names[name]]["rows"] += entry["arrays"]["t_ns"]["shape"][0]
        manifest["sources"].append(take.sha256)
        manifest["digest"] = extended_digest(manifest["digest"], f"{take.sha256} {document['content']}")

    def finish(self) -> None:
        """Arrays, tables and sensors on disk; the manifest says so, but is not written yet."""
        for heap in self._heaps.values():
            heap.close()
        for shard in self._shards.values():
            shard.close()
        self._finish_images()
        self._finish_signals()
        self._finish_frame_rows()
        for table, pieces in self._tables.items():
            self._write_part(table, pieces)
        if self._facts:
            self._manifest["sensors"] = write_sensors(self._path, self._facts)

    # -- tables ------------------------------------------------------------------------------------------------------

    def _frames(self, take: StagedTake) -> pa.Table:
        rows = self._manifest["rows"]
        table = take.table("frames").unify_dictionaries().combine_chunks()
        offset, length = self._add_images(take, table)
        trajectory = np.asarray(table["trajectory"])
        changed = {
            "trajectory": np.where(trajectory < 0, -1, trajectory + rows["trajectories"]),
            "source": np.full(len(table), rows["sources"]),
            "offset": offset,
            "length": length,
        }
        for name, values in changed.items():
            field = FRAME_SCHEMA.field(name)
            table = table.set_column(FRAME_SCHEMA.get_field_index(name), field, pa.array(values).cast(field.type))
        return table

    def _trajectories(self, take: StagedTake, names: Mapping[str, str], noted: Mapping[str, Entry]) -> pa.Table:
        rows = self._manifest["rows"]
        table = take.table("trajectories")

        def moved(text: str) -> str:
            ranges = {
                names[name]: [row + noted[names[name]]["rows"][0] for row in pair]
                for name, pair in json.loads(text or "{}").items()
                if name in names
            }
            return json_bytes(ranges).decode()

        changed = {
            "source": pa.array(np.full(len(table), rows["sources"]), pa.int32()),
            "frame_start": pc.add(table["frame_start"], rows["frames"]),
            "frame_stop": pc.add(table["frame_stop"], rows["frames"]),
            "signal_rows": pa.array([moved(text) for text in table["signal_rows"].to_pylist()], pa.string()),
        }
        for name, values in changed.items():
            table = table.set_column(TRAJECTORY_SCHEMA.get_field_index(name), TRAJECTORY_SCHEMA.field(name), values)
        return table

    def _findings(self, take: StagedTake, ours: list[Finding]) -> pa.Table:
        table = take.table("findings")
        known = set(
            zip(table["code"].to_pylist(), table["stream"].to_pylist(), table["message"].to_pylist(), strict=True)
        )
        new = [finding for finding in ours if (finding.code, finding.stream, finding.message) not in known]
        table = pa.concat_tables([table, findings_table(new)])
        source = pa.array(np.full(len(table), self._manifest["rows"]["sources"]), pa.int32())
        return table.set_column(0, FINDING_SCHEMA.field(0), source)

    def _write_part(self, table: str, pieces: list[pa.Table]) -> None:
        rows = pa.concat_tables(pieces).unify_dictionaries().combine_chunks()
        if not len(rows):
            return
        parts = self._manifest["index"][table]
        sink = pa.BufferOutputStream()
        pq.write_table(rows.cast(SCHEMAS[table]), sink, compression="zstd", row_group_size=ROW_GROUP)
        content = sink.getvalue().to_pybytes()
        path = part_path(table, len(parts))
        write_atomic(self._path / path, content)
        parts.append(
            {"file": path.removeprefix(table_folder(table) + "/"), "rows": len(rows), "sha256": sha256_of(content)}
        )

    # -- images ------------------------------------------------------------------------------------------------------

    def _add_images(self, take: StagedTake, frames: pa.Table) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Offset and length of each frame in the store, its bytes copied there."""
        encoding = np.array(frames["encoding"].cast(pa.string()).to_pylist(), dtype=object)
        camera = np.array(frames["camera"].cast(pa.string()).to_pylist(), dtype=object)
        height, width = np.asarray(frames["height"]), np.asarray(frames["width"])
        from_spool, in_spool = np.asarray(frames["offset"]), np.asarray(frames["length"])
        offset, length = np.full(len(frames), -1, dtype=np.int64), np.zeros(len(frames), dtype=np.int64)
        for name in dict.fromkeys(camera.tolist()):
            self._manifest["cameras"].setdefault(name, {"heap_bytes": 0, "rgb": {}})
            encoded = np.flatnonzero((camera == name) & (encoding != "raw") & (encoding != "missing"))
            if len(encoded):
                spool = take.folder / spool_name(name, "jpeg", 0, 0)
                offset[encoded] = self._heap(name).append(spool, from_spool[encoded], in_spool[encoded])
                length[encoded] = in_spool[encoded]
            raw = np.flatnonzero((camera == name) & (encoding == "raw"))
            sizes = dict.fromkeys(zip(height[raw].tolist(), width[raw].tolist(), strict=True))
            for size in sizes:
                of_size = raw[(height[raw] == size[0]) & (width[raw] == size[1])]
                spool = take.folder / spool_name(name, "raw", *size)
                offset[of_size] = self._shard(name, size).append(spool, from_spool[of_size], in_spool[of_size])
        return offset, length

    def _heap(self, camera: str) -> HeapAppender:
        if camera not in self._heaps:
            used = self._manifest["cameras"][camera]["heap_bytes"]
            if not used:
                create_heap(self._root, heap_path(camera), self._settings.heap_chunk_bytes)
            self._heaps[camera] = HeapAppender(self._path / heap_path(camera), self._settings.heap_chunk_bytes, used)
        return self._heaps[camera]

    def _shard(self, camera: str, size: tuple[int, int]) -> ShardAppender:
        path = rgb_path(camera, *size)
        if path not in self._shards:
            counts = self._manifest["cameras"][camera]["rgb"]
            capacity = self._settings.frames_per_shard(*size)
            if not counts.setdefault(f"{size[0]}x{size[1]}", 0):
                create_frames(self._root, path, size, capacity)
            self._shards[path] = ShardAppender(self._path / path, capacity, counts[f"{size[0]}x{size[1]}"])
        return self._shards[path]

    def _finish_images(self) -> None:
        for camera, facts in self._manifest["cameras"].items():
            if camera in self._heaps:
                facts["heap_bytes"] = self._heaps[camera].end
                set_length(self._path, heap_path(camera), facts["heap_bytes"])
            for size in facts["rgb"]:
                height, width = (int(side) for side in size.split("x"))
                path = rgb_path(camera, height, width)
                if path in self._shards:
                    facts["rgb"][size] = self._shards[path].count
                    set_length(self._path, path, facts["rgb"][size])

    # -- signals and values at frames --------------------------------------------------------------------------------

    def _variant(self, kind: str, name: str, entry: Entry) -> tuple[str, Finding | None]:
        """The name under which values are kept: their own, or another where that holds other columns, units or frame."""
        meaning = {key: entry[key] for key in ("columns", "units", "frame")}

        def fits(stored: str) -> bool:
            known = self._manifest[kind].get(stored)
            return known is None or all(known[key] == value for key, value in meaning.items())

        if fits(name):
            return name, None
        known = self._manifest[kind][name]
        stored = f"{name}@{entry['frame']}" if known["frame"] != entry["frame"] else ""
        if not stored or not fits(stored):
            stored = f"{name}@{digest_of(meaning)[:8]}"
        differing = [key for key, value in meaning.items() if known[key] != value]
        detail = "; ".join(f"{key} {entry[key]!r} here, {known[key]!r} there" for key in differing)
        message = f"{kind} {name!r} differs from what the store holds under that name ({detail}); kept as {stored!r}"
        return stored, Finding("signal-variant", "warning", message, stream=name)

    def _note(self, kind: str, stored: str, take: StagedTake, entry: Entry) -> dict[str, Any]:
        """Notes an entry's arrays for `finish`; returns what the sources table keeps of it."""
        facts = self._manifest[kind].setdefault(
            stored,
            {
                "rows": 0 if kind == "signals" else self._first_frame,
                **{key: entry[key] for key in ("columns", "units", "frame", "attributes")},
                "statistics": no_statistics(len(entry["columns"])),
            },
        )
        self._pending.setdefault((kind, stored), []).append((self._manifest["rows"]["frames"], take, entry))
        noted: dict[str, Any] = {"crc32c": {array: place["crc32c"] for array, place in entry["arrays"].items()}}
        noted["attributes"] = entry["attributes"]
        if kind == "signals":
            noted["rows"] = [facts["rows"], facts["rows"] + entry["arrays"]["t_ns"]["shape"][0]]
        return noted

    def _finish_signals(self) -> None:
        for (kind, name), noted in self._pending.items():
            if kind != "signals":
                continue
            facts = self._manifest["signals"][name]
            stop = facts["rows"]
            start = stop - sum(entry["arrays"]["t_ns"]["shape"][0] for _, _, entry in noted)
            for array in SIGNAL_ARRAYS:
                path = signal_path(name, array)
                width = len(facts["columns"]) if array == "value" else None
                if start == 0:
                    self._create(path, width, array, facts)
                blocks = (take.array(entry["arrays"][array]) for _, take, entry in noted)
                append_rows(self._path, path, start, stop, blocks)
            self._count_statistics(facts, (take.array(entry["arrays"]["value"]) for _, take, entry in noted))

    def _finish_frame_rows(self) -> None:
        """Values at frames: every array gets a row a frame, also where takes of this group have no such value."""
        start, stop = self._first_frame, self._manifest["rows"]["frames"]
        for kind, arrays in (("aligned", ALIGNED_ARRAYS), ("frame_values", ("value",))):
            for name, facts in self._manifest[kind].items():
                noted = self._pending.get((kind, name), [])
                for array in arrays:
                    path = aligned_path(name, array) if kind == "aligned" else frame_values_path(name)
                    width = len(facts["columns"]) if array == "value" else None
                    if not (self._path / path).exists():
                        self._create(path, width, array, facts)
                    if noted:
                        append_rows(self._path, path, start, stop, self._filled(noted, array, width, start, stop))
                    else:
                        set_length(self._path, path, stop)
                facts["rows"] = stop
                self._count_statistics(facts, (take.array(entry["arrays"]["value"]) for _, take, entry in noted))

    def _filled(
        self, noted: list[tuple[int, StagedTake, Entry]], array: str, width: int | None, start: int, stop: int
    ) -> Iterator[NDArray[Any]]:
        """Blocks of rows [start, stop): those of the takes that have the value, nothing known between them."""
        dtype, fill = FILL.get(array, ("<f8", np.nan))

        def nothing(count: int) -> Iterator[NDArray[Any]]:
            while count > 0:
                block = min(count, ROW_GROUP)
                yield np.full((block,) if width is None else (block, width), fill, dtype=dtype)
                count -= block

        row = start
        for first, take, entry in noted:
            yield from nothing(first - row)
            values = take.array(entry["arrays"][array])
            yield values
            row = first + len(values)
        yield from nothing(stop - row)

    def _create(self, path: str, width: int | None, array: str, facts: Entry) -> None:
        dtype, fill = FILL.get(array, ("<f8", np.nan))
        described = (
            {key: facts[key] for key in ("columns", "units", "frame", "attributes")}
            if width is not None
            else {"unit": "ns"}
        )
        create_rows(self._root, path, width, dtype, fill, self._settings.signal_chunk_rows, described)

    def _count_statistics(self, facts: dict[str, Any], blocks: Iterator[NDArray[Any]]) -> None:
        for block in blocks:
            for start in range(0, len(block), ROW_GROUP):
                facts["statistics"] = added(facts["statistics"], np.asarray(block[start : start + ROW_GROUP]))

    # -- sensors -----------------------------------------------------------------------------------------------------

    def _add_sensors(self, take: StagedTake) -> list[Finding]:
        self._facts, findings = merged_facts(self._facts, take.document["sensors"])
        for sensor, entry in take.document["references"].items():
            image = np.asarray(take.array(entry["arrays"]["image"]))
            if sensor in self._manifest["references"]:
                conflict = reference_conflict(sensor, self._reference(sensor), image)
                findings += [conflict] if conflict else []
                continue
            write_image(self._root, reference_path(sensor), image, {"sensor": sensor, **entry["attributes"]})
            self._manifest["references"][sensor] = image_crc(image)
            self._references[sensor] = image
        return findings

    def _reference(self, sensor: str) -> NDArray[np.uint8]:
        if sensor not in self._references:
            array = self._root[reference_path(sensor)]
            assert isinstance(array, zarr.Array)
            self._references[sensor] = np.asarray(array[...])
        return self._references[sensor]


def sha256_of(content: bytes) -> str:
    """SHA-256 (hex) of bytes."""
    import hashlib

    return hashlib.sha256(content).hexdigest()


def _source_row(document: Entry, contents: Mapping[str, Any]) -> pa.Table:
    row = {
        "sha256": document["sha256"],
        "key": document["key"],
        "format": document["format"],
        "frames": document["n_frames"],
        "trajectories": document["n_trajectories"],
        "status": document["status"],
        "description": json_bytes(document["description"]).decode(),
        "provenance": json_bytes(document["provenance"]).decode(),
        "contents": json_bytes(contents).decode(),
    }
    return pa.Table.from_pylist([row], schema=SOURCE_SCHEMA)


__all__ = ["Appender", "folder_name", "sha256_of"]
