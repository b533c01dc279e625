"""How the records of an MCAP lie in a file: their heads, and whether a head can be one.

Source: the MCAP specification, version 0. The record classes of the `mcap` package parse the records that are small and
few; chunks and messages are unpacked here, because they are many.
"""

from __future__ import annotations

import io
import struct
from dataclasses import dataclass
from typing import Any

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode

MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")
"""Opcode and length of every record."""
MESSAGE = struct.Struct("<BQHIqq")
"""Head of a message record, then channel, sequence, log time and publish time (signed: a negative one is nonsense)."""
MESSAGE_FIELDS = MESSAGE.size - HEAD.size
CHUNK = struct.Struct("<QQQII")
"""Start time, end time, uncompressed size, CRC, length of the compression's name."""
FOOTER_BYTES = HEAD.size + 20
DATA_END_BYTES = HEAD.size + 4

HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE_RECORD, CHUNK_RECORD, MESSAGE_INDEX = (
    int(code)
    for code in (
        Opcode.HEADER,
        Opcode.FOOTER,
        Opcode.SCHEMA,
        Opcode.CHANNEL,
        Opcode.MESSAGE,
        Opcode.CHUNK,
        Opcode.MESSAGE_INDEX,
    )
)
CHUNK_INDEX, ATTACHMENT, ATTACHMENT_INDEX, STATISTICS, METADATA, METADATA_INDEX, SUMMARY_OFFSET, DATA_END = (
    int(code)
    for code in (
        Opcode.CHUNK_INDEX,
        Opcode.ATTACHMENT,
        Opcode.ATTACHMENT_INDEX,
        Opcode.STATISTICS,
        Opcode.METADATA,
        Opcode.METADATA_INDEX,
        Opcode.SUMMARY_OFFSET,
        Opcode.DATA_END,
    )
)
SUMMARY_ONLY = frozenset({FOOTER, CHUNK_INDEX, ATTACHMENT_INDEX, STATISTICS, METADATA_INDEX, SUMMARY_OFFSET})
"""Records that stand behind the end of the data section."""

SHORTEST = {
    HEADER: 8,
    FOOTER: 20,
    SCHEMA: 14,
    CHANNEL: 16,
    MESSAGE_RECORD: MESSAGE_FIELDS,
    CHUNK_RECORD: CHUNK.size + 8,
    MESSAGE_INDEX: 6,
    CHUNK_INDEX: 60,
    ATTACHMENT: 36,
    ATTACHMENT_INDEX: 48,
    STATISTICS: 46,
    METADATA: 8,
    METADATA_INDEX: 20,
    SUMMARY_OFFSET: 17,
    DATA_END: 4,
}
FIRST_PRIVATE_OPCODE = 0x80
"""Opcodes from here on belong to applications: their records are stepped over."""
MAX_RECORD_BYTES = 2**30
"""Largest record that is taken into memory: larger ones are reported and stepped over."""


class StrictStream(ReadDataStream):
    """The `mcap` package's stream, but a field that ends early is an error instead of a shorter field."""

    def read(self, length: int) -> bytes:
        """Exactly ``length`` bytes."""
        data = super().read(length)
        if len(data) != length:
            raise EndOfFile
        return data


def parse(record_class: Any, body: bytes) -> Any:
    """A record of one of `mcap.records`' classes; raises `EndOfFile` or `ValueError` where the body is damaged."""
    return record_class.read(StrictStream(io.BytesIO(body)))


@dataclass(frozen=True, slots=True)
class ChunkHead:
    """What a chunk record says before its data: times in ns, sizes in bytes, where the data begin in the body."""

    start_ns: int
    end_ns: int
    uncompressed_size: int
    crc: int
    compression: str
    stored_size: int
    data_start: int

    @property
    def record_length(self) -> int:
        """The record's length as its own inner fields state it."""
        return self.data_start + self.stored_size


def chunk_head(body: bytes) -> ChunkHead | None:
    """The head of a chunk from the first bytes of its body; ``None`` where they cannot be one."""
    if len(body) < CHUNK.size + 8:
        return None
    start, end, size, crc, name_length = CHUNK.unpack_from(body)
    data_start = CHUNK.size + name_length + 8
    if name_length > 16 or len(body) < data_start:
        return None
    name = bytes(body[CHUNK.size : CHUNK.size + name_length])
    if not name.isascii() or not (name == b"" or name.isalnum()):
        return None
    (stored,) = struct.unpack_from("<Q", body, data_start - 8)
    return ChunkHead(start, end, size, crc, name.decode(), stored, data_start)


def is_head(opcode: int, length: int, room: int) -> bool:
    """Whether a record with this opcode and length can stand where ``room`` bytes follow its head.

    Parameters
    ----------
    opcode : int
        Kind of the record.
    length : int
        Bytes of its body, as the head says.
    room : int
        Bytes that follow the head.
    """
    if length > room:
        return False
    shortest = SHORTEST.get(opcode)
    return opcode >= FIRST_PRIVATE_OPCODE if shortest is None else length >= shortest


def is_record(opcode: int, length: int, body: bytes, room: int) -> bool:
    """Whether a head and the first bytes of its body agree with one another; stricter than `is_head`.

    Parameters
    ----------
    opcode : int
        Kind of the record.
    length : int
        Bytes of its body, as the head says.
    body : bytes
        The first bytes of its body.
    room : int
        Bytes that follow the head.
    """
    if not is_head(opcode, length, room):
        return False
    if opcode == CHUNK_RECORD:
        head = chunk_head(body)
        return head is not None and head.record_length == length
    if opcode == MESSAGE_INDEX:
        return (length - 6) % 16 == 0 and struct.unpack_from("<I", body, 2)[0] == length - 6
    if opcode == DATA_END:
        return length == SHORTEST[DATA_END]
    if opcode == FOOTER:
        return length == SHORTEST[FOOTER]
    return opcode < FIRST_PRIVATE_OPCODE
