"""Bytes in memory of Arrow's own, so that its threads can let go of them whenever they like."""

from __future__ import annotations

import pyarrow as pa


def arrow_reader(content: bytes) -> pa.BufferReader:
    """Return a reader of a copy of bytes that Python does not own.

    A thread of Arrow may drop what it has read a moment after the caller has the table. Bytes of Python's it could drop
    only by way of the interpreter; where this is shutting down, the process ends with "terminate called without an
    active exception", after the command has done all its work.
    """
    copy = pa.BufferOutputStream()
    copy.write(content)
    return pa.BufferReader(copy.getvalue())
