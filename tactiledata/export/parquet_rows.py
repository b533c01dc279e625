"""Rows of frames as parquet files that Hugging Face's `datasets` opens with pictures decoded."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

IMAGE = pa.struct([("bytes", pa.binary()), ("path", pa.string())])
"""How `datasets` keeps a picture: the bytes of its file, and a name."""
SUFFIX = {"jpeg": "jpg", "png": "png"}


@dataclass(frozen=True)
class RowField:
    """A column of a parquet file.

    Parameters
    ----------
    name : str
    kind : pa.DataType
    feature : dict
        What `datasets` calls the column's type.
    facts : dict of str
        Unit, frame and meaning, kept in the file's schema.
    """

    name: str
    kind: pa.DataType
    feature: Mapping[str, Any]
    facts: Mapping[str, str]

    @classmethod
    def picture(cls, name: str) -> RowField:
        """Return the column of a camera's pictures."""
        return cls(name, IMAGE, {"_type": "Image"}, {})

    @classmethod
    def scalar(cls, name: str, kind: str) -> RowField:
        """Return a column of single values: ``int64``, ``float32``, ``bool``, ``string`` …"""
        types = {"bool": pa.bool_(), "string": pa.string()}
        return cls(name, types.get(kind) or pa.type_for_alias(kind), {"dtype": kind, "_type": "Value"}, {})

    @classmethod
    def vector(cls, name: str, kind: str, length: int, facts: Mapping[str, Any] | None = None) -> RowField:
        """Return a column of vectors of one length.

        Parameters
        ----------
        name : str
            Of the column.
        kind : str
            Type of a number, for example ``float32``.
        length : int
            Numbers of a vector.
        facts : dict, optional
            Columns, units, frame and meaning.
        """
        said = {key: " ".join(value) if isinstance(value, list) else str(value) for key, value in (facts or {}).items()}
        feature = {"feature": {"dtype": kind, "_type": "Value"}, "length": length, "_type": "List"}
        return cls(name, pa.list_(pa.type_for_alias(kind), length), feature, said)


def schema_of(fields: Sequence[RowField]) -> pa.Schema:
    """Return the schema of rows with these columns, with the features that `datasets` reads from it."""
    features = {field.name: dict(field.feature) for field in fields}
    columns = [pa.field(field.name, field.kind, metadata=dict(field.facts) or None) for field in fields]
    return pa.schema(columns, metadata={"huggingface": json.dumps({"info": {"features": features}})})


def vectors(values: NDArray[Any], kind: str) -> pa.Array:
    """Return numbers (n, k) as a column of vectors."""
    flat = pa.array(np.ascontiguousarray(values).reshape(-1).astype(kind))
    return pa.FixedSizeListArray.from_arrays(flat, values.shape[1])


def pictures(contents: Sequence[bytes], names: Sequence[str]) -> pa.Array:
    """Return pictures as a column that `datasets` decodes."""
    return pa.StructArray.from_arrays(
        [pa.array(contents, pa.binary()), pa.array(names, pa.string())], fields=list(IMAGE)
    )


def write_rows(path: Path, schema: pa.Schema, batches: Iterable[Mapping[str, Any]]) -> None:
    """Write a parquet file, a row group for each batch of columns.

    Parameters
    ----------
    path : Path
        The file.
    schema : pa.Schema
        Its columns.
    batches : iterable of dict
        Columns by name.
    """
    texts = [field.name for field in schema if pa.types.is_string(field.type)]
    numbers = [field.name for field in schema if not pa.types.is_struct(field.type)]
    with pq.ParquetWriter(
        path, schema, compression="zstd", use_dictionary=texts or False, write_statistics=numbers or False
    ) as writer:
        for columns in batches:
            arrays = [
                columns[field.name]
                if isinstance(columns[field.name], pa.Array)
                else pa.array(columns[field.name], field.type)
                for field in schema
            ]
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema))
