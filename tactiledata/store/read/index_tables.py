"""The tables of a store's index: read part by part, each held against its digest in the manifest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa

from tactiledata.contract.arrow_memory import arrow_reader, read_parquet
from tactiledata.contract.provenance import bytes_digest
from tactiledata.errors import StoreError, UnknownName
from tactiledata.store.layout.places import TABLE_SCHEMAS, table_folder
from tactiledata.store.read.files import StoreFiles, missing_file


class IndexTables:
    """Reads frames, trajectories, sources and findings; picklable."""

    def __init__(self, files: StoreFiles, manifest: Mapping[str, Any]) -> None:
        self._files, self._manifest = files, manifest
        self._whole_parts: set[str] = set()

    def read(self, table: str, columns: Sequence[str] | None = None) -> pa.Table:
        """A table over all its parts, or some of its columns.

        Raises
        ------
        UnknownName
            The table has no such column.
        StoreError
            A part is damaged.
        """
        schema = TABLE_SCHEMAS[table]
        for column in columns or ():
            if column not in schema.names:
                raise UnknownName(f"column of {table}", column, schema.names)
        wanted = pa.schema([schema.field(name) for name in (schema.names if columns is None else columns)])
        pieces = [wanted.empty_table()]
        for part in self._manifest["index"][table]:
            path = f"{table_folder(table)}/{part['file']}"
            try:
                # one file, not a dataset of many: of small parts that took three times as long
                piece = read_parquet(self._part(path, part["sha256"]), wanted)
            except FileNotFoundError as error:
                raise missing_file(path, self._files.location) from error
            except (pa.ArrowException, OSError, KeyError) as error:
                raise StoreError(
                    f"the part {path} of the store {self._files.location} is damaged: {error}",
                    "a parquet file that fits the manifest",
                    "Run `tactiledata check` on the store; restore the file from a copy.",
                ) from error
            if len(piece) != part["rows"]:
                raise StoreError(f"{path} has {len(piece)} rows", f"the {part['rows']} rows that the manifest names")
            pieces.append(piece)
        return pa.concat_tables(pieces).unify_dictionaries()

    def _part(self, path: str, sha256: str) -> Path | pa.BufferReader:
        """A part of a table, to read from; its bytes are held against the manifest the first time.

        A flipped byte mostly still reads, to other numbers; whoever writes them on would give them a fitting checksum.
        """
        if path in self._whole_parts and isinstance(place := self._files.place(path), Path):
            return place
        content = self._files.read(path)
        if (digest := bytes_digest(content)) != sha256:
            raise StoreError(
                f"the part {path} of the store {self._files.location} is damaged: its SHA-256 is {digest[:12]}…",
                f"{sha256[:12]}…, as the manifest says",
                "Restore the file from a copy, or ingest the recordings into a new store; `tactiledata check` lists "
                "all damage.",
            )
        self._whole_parts.add(path)
        return arrow_reader(content)
