"""Reading tables so that no thread of Arrow outlives it, and bytes that such a thread may let go of at any time."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq


def arrow_reader(content: bytes) -> pa.BufferReader:
    """Return a reader of a copy of bytes that Python does not own.

    A thread of Arrow may drop what it has read a moment after the caller has the table. Bytes of Python's it could drop
    only by way of the interpreter; where this is shutting down, the process ends with "terminate called without an
    active exception", after the command has done all its work.
    """
    copy = pa.BufferOutputStream()
    copy.write(content)
    return pa.BufferReader(copy.getvalue())


def read_parquet(source: Path | pa.BufferReader, schema: pa.Schema) -> pa.Table:
    """Return the columns of a schema from a parquet file, in its order and of its types.

    `pyarrow.parquet.read_table` scans a dataset: its threads read ahead and may still run when the caller has the
    table. Where the process ends just then, it is aborted (apache/arrow issues 34314 and 39862).

    Parameters
    ----------
    source : Path or BufferReader
        The file, or a reader of its bytes.
    schema : Schema
        Columns that are read; others are left out.

    Raises
    ------
    KeyError
        A column is not there.
    ArrowException
        The file is damaged, or a column is of a type that cannot be turned into that of the schema.
    """
    with pq.ParquetFile(source) as file:
        return file.read(columns=schema.names).select(schema.names).cast(schema)
