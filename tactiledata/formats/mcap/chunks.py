"""The content of a chunk, decompressed within bounds and vouched for by its CRC, by a thread ahead of the reader."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor

import lz4.frame
import zstandard

from tactiledata.errors import BrokenLog
from tactiledata.formats.mcap.layout import CHUNK_RECORD, HEAD, ChunkHead, chunk_head
from tactiledata.formats.mcap.records import LostSpan, Record

MAX_CHUNK_BYTES = 2**29
"""Largest content of a chunk that is taken into memory; writers use some MB."""
HIGHEST_RATIO = {"zstd": 60_000, "lz4": 256}
"""How many times larger than the stored bytes a content can be; a larger claim is a bomb or damage."""

Content = tuple[ChunkHead, bytes] | BrokenLog | None
"""Head and records of a chunk, or why they cannot be had; ``None`` for what is no chunk."""
Met = tuple[Record | LostSpan, Content]

MOST_RECORDS = 64
ENOUGH_BYTES = 2**18
"""Records are read together until they are so many or have so many bytes: less is not worth a hand-over."""
AHEAD_BYTES = 8 * 2**20
"""Size, bytes, of records beside which nothing is read ahead if they have more, as memory would hold two such."""


def chunk_content(body: bytes) -> tuple[ChunkHead, bytes]:
    """A chunk's head and its records.

    Raises
    ------
    BrokenLog
        The content does not decompress to what the head says, or its CRC is another one; ``facts["code"]`` is the
        finding's code. A CRC of 0 means that none was recorded: the content is then returned as it is.
    """
    head = chunk_head(body)
    if head is None or head.record_length > len(body):
        raise BrokenLog("a chunk whose head does not fit its length", code="chunk-damaged")
    stored = body[head.data_start : head.record_length]
    if head.uncompressed_size > MAX_CHUNK_BYTES or head.uncompressed_size > _bound(head):
        raise BrokenLog(
            f"a chunk that claims {head.uncompressed_size} bytes from {len(stored)} stored ones", code="chunk-size"
        )
    content = _decompressed(head, stored)
    if len(content) != head.uncompressed_size:
        raise BrokenLog(f"a chunk of {len(content)} bytes, {head.uncompressed_size} expected", code="chunk-damaged")
    if head.crc and zlib.crc32(content) != head.crc:
        raise BrokenLog(f"a chunk whose CRC is {zlib.crc32(content):08x}, {head.crc:08x} expected", code="chunk-crc")
    return head, content


def _bound(head: ChunkHead) -> int:
    return head.stored_size * HIGHEST_RATIO.get(head.compression, 1) + 64


def _decompressed(head: ChunkHead, stored: bytes) -> bytes:
    try:
        if head.compression == "":
            return bytes(stored)
        if head.compression == "zstd":
            stated = zstandard.frame_content_size(stored)
            if stated not in (-1, head.uncompressed_size):
                raise BrokenLog(
                    f"a zstd frame of {stated} bytes in a chunk of {head.uncompressed_size}", code="chunk-crc"
                )
            return zstandard.ZstdDecompressor().decompress(stored, max_output_size=head.uncompressed_size)
        if head.compression == "lz4":
            return lz4.frame.LZ4FrameDecompressor().decompress(stored, max_length=head.uncompressed_size + 1)
    except (zstandard.ZstdError, RuntimeError, EOFError, ValueError) as error:
        if isinstance(error, BrokenLog):
            raise
        raise BrokenLog(f"a chunk that does not decompress ({error})", code="chunk-crc") from error
    raise BrokenLog(
        f"a chunk compressed with {head.compression!r}", "lz4, zstd or no compression", code="chunk-compression"
    )


def records_in(content: bytes) -> Iterator[tuple[int, int, int]]:
    """Opcode, start and stop of the bodies of the records in a chunk; raises `BrokenLog` where one overruns."""
    position, end = 0, len(content)
    while position < end:
        if position + HEAD.size > end:
            raise BrokenLog(f"{end - position} bytes too many in a chunk", code="chunk-content")
        opcode, length = HEAD.unpack_from(content, position)
        start = position + HEAD.size
        position = start + length
        if position > end:
            raise BrokenLog(f"a record of {length} bytes that leaves its chunk", code="chunk-content")
        yield opcode, start, position


def read_ahead(records: Iterable[Record | LostSpan]) -> Iterator[Met]:
    """Each record in its order, and what it holds if it is a chunk.

    Parameters
    ----------
    records : iterable of Record or LostSpan
        Drawn from by one thread at a time, some records before they are asked for.
    """
    source = iter(records)
    with ThreadPoolExecutor(1, thread_name_prefix="read-ahead") as thread:
        several, n_bytes = _next_records(source)
        while several:
            waiting = thread.submit(_next_records, source) if n_bytes <= AHEAD_BYTES else None
            yield from several
            several.clear()  # their memory before that of the next ones
            several, n_bytes = waiting.result() if waiting else _next_records(source)


def _next_records(source: Iterator[Record | LostSpan]) -> tuple[list[Met], int]:
    """Some records, none at the end, and how many bytes they and the contents of their chunks have."""
    several: list[Met] = []
    n_bytes = 0
    for record in source:
        content = _content(record) if isinstance(record, Record) and record.opcode == CHUNK_RECORD else None
        several.append((record, content))
        n_bytes += len(record.body) if isinstance(record, Record) else 0
        n_bytes += len(content[1]) if isinstance(content, tuple) else 0
        if n_bytes >= ENOUGH_BYTES or len(several) == MOST_RECORDS:
            break
    return several, n_bytes


def _content(record: Record) -> Content:
    try:
        return chunk_content(record.body)
    except BrokenLog as fault:
        return fault
