"""One group of takes on its way into a store: row numbers made global, arrays appended, tables written as new parts."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from tactiledata.contract.provenance import bytes_digest, json_bytes
from tactiledata.contract.records import Finding
from tactiledata.contract.take import SOURCE_SCHEMA, findings_table
from tactiledata.store.layout.arrays import open_root
from tactiledata.store.layout.batch import Batch
from tactiledata.store.layout.manifest import Manifest, extended_digest
from tactiledata.store.layout.places import TABLE_SCHEMAS, TABLES, table_folder
from tactiledata.store.write.image_appender import ImageAppender
from tactiledata.store.write.sensor_appender import SensorAppender
from tactiledata.store.write.value_appender import ValueAppender
from tactiledata.store.write.writer import StagedTake

ROW_GROUP = 65_536


class Appender:
    """Appends takes after what a manifest names, and changes that manifest; nothing counts until it is written.

    Parameters
    ----------
    batch : Batch
    manifest : dict
        Changed in place.
    first_part : dict, optional
        Lowest number of a new part of each table.

    Attributes
    ----------
    sensors : SensorAppender
    """

    def __init__(self, batch: Batch, manifest: Manifest, first_part: Mapping[str, int] | None = None) -> None:
        self._batch, self._manifest = batch, manifest
        self._first_part = first_part or dict.fromkeys(TABLES, 0)
        root = open_root(batch)
        self._images = ImageAppender(batch, root, manifest)
        self._values = ValueAppender(batch, root, manifest)
        self.sensors = SensorAppender(batch, root, manifest)
        self._pieces: dict[str, list[pa.Table]] = {table: [] for table in TABLES}

    def add(self, take: StagedTake) -> None:
        """One take: images appended at once, rows kept for the new parts, values noted for `finish`."""
        take.check()
        document, manifest = take.document, self._manifest
        findings = self.sensors.add(take)
        contents, names, variants = self._values.add(take)
        contents |= {name: sorted(document[name]) for name in ("sensors", "references")}
        contents["content"] = document["content"]
        pieces = {
            "frames": self._frames(take),
            "trajectories": self._trajectories(take, names, contents["signals"]),
            "sources": _source_row(document, contents),
            "findings": self._findings(take, [*findings, *variants]),
        }
        for table, piece in pieces.items():
            self._pieces[table].append(piece)
            manifest["rows"][table] += len(piece)
        manifest["sources"].append(take.sha256)
        manifest["digest"] = extended_digest(manifest["digest"], f"{take.sha256} {document['content']}")

    def finish(self) -> None:
        """Arrays, tables and sensors written into the batch; the manifest says so, but is not written yet."""
        self._images.finish()
        self._values.finish()
        self.sensors.finish()
        for table, pieces in self._pieces.items():
            rows = pa.concat_tables(pieces).unify_dictionaries().combine_chunks()
            if len(rows):
                self._manifest["index"][table].append(write_part(self._batch, table, self._next_file(table), rows))

    def _next_file(self, table: str) -> str:
        """A file name that no part has, nor had before the manifest was emptied."""
        return f"part-{max(self._first_part[table], 1 + last_part(self._manifest, table)):05d}.parquet"

    def _frames(self, take: StagedTake) -> pa.Table:
        rows = self._manifest["rows"]
        table = take.table("frames").unify_dictionaries().combine_chunks()
        if take.is_placed:
            offset, length = np.asarray(table["offset"]), np.asarray(table["length"])
        else:
            offset, length = self._images.add(take, table)
        trajectory = np.asarray(table["trajectory"])
        changed = {
            "trajectory": np.where(trajectory < 0, -1, trajectory + rows["trajectories"]),
            "source": np.full(len(table), rows["sources"]),
            "offset": offset,
            "length": length,
        }
        return _with_columns(table, {name: pa.array(values) for name, values in changed.items()})

    def _trajectories(self, take: StagedTake, names: Mapping[str, str], noted: Mapping[str, Any]) -> pa.Table:
        rows = self._manifest["rows"]
        table = take.table("trajectories")
        ranges = [
            {
                names[name]: [row + noted[names[name]]["rows"][0] for row in pair]
                for name, pair in json.loads(text).items()
            }
            for text in table["signal_rows"].to_pylist()
        ]
        changed = {
            "source": pa.array(np.full(len(table), rows["sources"])),
            "frame_start": pc.add(table["frame_start"], rows["frames"]),
            "frame_stop": pc.add(table["frame_stop"], rows["frames"]),
            "signal_rows": pa.array([json_bytes(entry).decode() for entry in ranges], pa.string()),
        }
        return _with_columns(table, changed)

    def _findings(self, take: StagedTake, ours: list[Finding]) -> pa.Table:
        table = take.table("findings")
        keys = ("code", "stream", "message")
        known = set(zip(*(table[key].to_pylist() for key in keys), strict=True))
        new = [finding for finding in ours if (finding.code, finding.stream, finding.message) not in known]
        table = pa.concat_tables([table, findings_table(new)])
        return _with_columns(table, {"source": pa.array(np.full(len(table), self._manifest["rows"]["sources"]))})


def last_part(manifest: Manifest, table: str) -> int:
    """The highest number among the parts of a table; -1 where there are none."""
    numbers = [
        int(part["file"].removeprefix("part-").removesuffix(".parquet").partition("-")[0])
        for part in manifest["index"][table]
    ]
    return max(numbers, default=-1)


def _with_columns(table: pa.Table, columns: Mapping[str, Any]) -> pa.Table:
    for name, values in columns.items():
        field = table.schema.field(name)
        table = table.set_column(table.schema.get_field_index(name), field, values.cast(field.type))
    return table


def _source_row(document: Mapping[str, Any], contents: Mapping[str, Any]) -> pa.Table:
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


def write_part(batch: Batch, table: str, file: str, rows: pa.Table) -> dict[str, Any]:
    """A part of a table in its file; returns its entry for the manifest.

    Parameters
    ----------
    batch : Batch
        Takes the file.
    table : str
        One of ``TABLES``.
    file : str
        Name of the part's file in the folder of the table.
    rows : Table
        Rows of the part; they are cast to the schema of the table.
    """
    sink = pa.BufferOutputStream()
    pq.write_table(rows.cast(TABLE_SCHEMAS[table]), sink, compression="zstd", row_group_size=ROW_GROUP)
    content = sink.getvalue().to_pybytes()
    batch.write(f"{table_folder(table)}/{file}", content)
    return {"file": file, "rows": len(rows), "sha256": bytes_digest(content)}
