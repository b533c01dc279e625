"""The records of a file's data section in order; where the file is damaged, the loss is said and the rest goes on."""

from __future__ import annotations

import re
import shlex
import zlib
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from tactiledata.contract.wording import agreeing, counted
from tactiledata.formats.mcap.layout import (
    ATTACHMENT,
    CHANNEL,
    CHUNK_RECORD,
    DATA_END,
    FOOTER,
    FOOTER_BYTES,
    HEAD,
    MAGIC,
    MAX_RECORD_BYTES,
    MESSAGE_INDEX,
    MESSAGE_RECORD,
    METADATA,
    SCHEMA,
    SHORTEST,
    SUMMARY_ONLY,
    chunk_head,
    is_head,
    is_record,
)

PEEK_BYTES = 96
"""Enough of a body to judge it: the head of a chunk, the fixed fields of the others."""
ATTACHMENT_HEAD_BYTES = 4096
"""As much of an attachment as is handed on: its name, not its data."""
UNVOUCHED = frozenset({MESSAGE_RECORD, SCHEMA, CHANNEL, METADATA})
"""Records outside chunks: no CRC stands for them alone."""
SCAN_WINDOW = 4 * 2**20
CHAIN = 2
"""How many records must follow one another before a place found by scanning is believed to be a record's begin."""
_ANY_HEAD = re.compile(rb"(?=[\x03-\x0f][\x00-\xff]{5}\x00\x00\x00)")
_OUTER_HEAD = re.compile(rb"(?=[\x06-\x0f][\x00-\xff]{5}\x00\x00\x00)")


@dataclass(frozen=True, slots=True)
class Record:
    """A record of the data section: where it begins, and its body (of an attachment only the first bytes)."""

    opcode: int
    offset: int
    length: int
    body: bytes


@dataclass(frozen=True, slots=True)
class LostSpan:
    """A part of a file that cannot be read.

    ``start_ns`` and ``end_ns`` are log times where the file tells them; ``None`` means: between the neighbours.
    ``count`` is the number of messages lost, ``None`` where nobody knows.
    """

    code: str
    message: str
    start_ns: int | None = None
    end_ns: int | None = None
    count: int | None = None


@dataclass(frozen=True)
class Landmarks:
    """What an intact summary says of a data section: where its chunks begin, and where it ends."""

    chunks: Sequence[int] = ()
    stop: int | None = None
    is_chunked: bool | None = None


class RecordWalker:
    """The records of one file, with resynchronisation after damage.

    A record is handed on only once the head of the next one fits, because a damaged length shows only there.

    Parameters
    ----------
    stream : binary file
    size : int
        Bytes in the file.
    landmarks : Landmarks
        From a summary that can be trusted; empty ones otherwise.
    with_crc : bool
        Whether to compute the CRC of the data section; `data_crc` then holds it after an undamaged walk.
    """

    def __init__(self, stream: BinaryIO, size: int, landmarks: Landmarks, with_crc: bool = False) -> None:
        self._stream = stream
        self._size = size
        self._landmarks = landmarks
        self._stop = size if landmarks.stop is None else min(size, landmarks.stop)
        self._crc: int | None = zlib.crc32(self._bytes_at(0, len(MAGIC))) if with_crc else None
        self._saw_message = False
        self._saw_chunk = bool(landmarks.is_chunked)
        self.data_crc: int | None = None
        self.reached_end = False

    def __iter__(self) -> Iterator[Record | LostSpan]:
        position = len(MAGIC)
        head = self._bytes_at(position, HEAD.size)
        while position < self._stop:
            opcode, length = self._unpacked(head)
            if opcode in SUMMARY_ONLY and is_head(opcode, length, self._size - position - HEAD.size):
                yield LostSpan("no-data-end", f"the end of the data section is missing before byte {position}")
                return
            if opcode == DATA_END and is_head(opcode, length, self._size - position - HEAD.size):
                self.reached_end = True
                self.data_crc = self._crc
                yield Record(opcode, position, length, self._bytes_at(position + HEAD.size, length))
                return
            step = self._step(position, opcode, length)
            yield from step.found
            position, head = step.position, step.head
        if self._landmarks.stop is not None:
            yield LostSpan("no-data-end", f"the end of the data section is missing before byte {position}")

    # one record ahead, or over damage

    def _step(self, position: int, opcode: int, length: int) -> _Step:
        room = self._size - position - HEAD.size
        if not is_head(opcode, length, room) or (opcode == CHUNK_RECORD and not self._chunk_fits(position, length)):
            return self._recover(position, opcode)
        if length > MAX_RECORD_BYTES and opcode != ATTACHMENT:
            if not self._is_chain(position + HEAD.size + length, CHAIN):
                return self._recover(position, opcode)
            loss = LostSpan("record-size", f"a record of {length} bytes at byte {position} is too large to be read")
            return self._forward(position + HEAD.size + length, [loss])
        body, head = self._body(position, opcode, length)
        after = position + HEAD.size + length
        next_opcode, next_length = self._unpacked(head)
        if after < self._size and not is_head(next_opcode, next_length, self._size - after - HEAD.size):
            return self._doubted(Record(opcode, position, length, body), after, head)
        return _Step([self._noted(Record(opcode, position, length, body))], after, head)

    def _doubted(self, record: Record, after: int, head: bytes) -> _Step:
        """A record whose successor has no head: its own length may be wrong, or its end lie in what is damaged."""
        if record.opcode == CHUNK_RECORD:
            return _Step([self._noted(record)], after, head)  # its inner lengths agreed, and its CRC will tell
        found = self._next_record(record.offset + 1)
        if found is not None and found < after:
            return self._forward(found, [self._loss(record.offset, found, "record-damaged")])
        if record.opcode in UNVOUCHED and not self._is_begun(after, head):
            text = f"the record at byte {record.offset} ends where bytes begin that are no records: it is not used"
            count = 1 if record.opcode == MESSAGE_RECORD else 0
            return _Step([LostSpan("record-damaged", text, count=count)], after, head)
        return _Step([self._noted(record)], after, head)

    def _is_begun(self, position: int, head: bytes) -> bool:
        """Whether the bytes behind a record are a record's begin, merely torn or with one wrong field."""
        _, length = self._unpacked(head)
        after = position + HEAD.size + length
        return head[0] in SHORTEST or (len(head) == HEAD.size and after < self._size and self._is_chain(after, 1))

    def _recover(self, position: int, opcode: int) -> _Step:
        """What can be done where no readable record begins."""
        if opcode == CHUNK_RECORD:
            step = self._chunk_recovered(position)
            if step is not None:
                return step
        found = self._next_record(position + 1)
        stop = self._stop if found is None else found
        return self._forward(stop, [self._loss(position, stop, "lost-bytes")])

    def _chunk_recovered(self, position: int) -> _Step | None:
        """A chunk with one damaged length, where the other leads to a record; or one that the file's end tears."""
        self._saw_chunk = True
        _, outer = self._unpacked(self._bytes_at(position, HEAD.size))
        start = position + HEAD.size
        head = chunk_head(self._bytes_at(start, PEEK_BYTES))
        if head is None:
            return None
        for length in (head.record_length, outer):
            if head.data_start <= length <= self._size - start and self._is_chain(start + length, CHAIN - 1):
                return self._mended(position, head.data_start, length)
        if start + head.record_length > self._size and self._next_record(position + 1) is None:
            torn = f"the file ends inside the chunk at byte {position}"
            return self._forward(self._size, [LostSpan("torn-chunk", torn, head.start_ns, head.end_ns)])
        return None

    def _mended(self, position: int, data_start: int, length: int) -> _Step:
        """A chunk whose lengths disagree, with the one that leads to a record; its CRC must vouch for the content."""
        body = self._bytes_at(position + HEAD.size, length)
        stored = (length - data_start).to_bytes(8, "little")
        record = Record(CHUNK_RECORD, position, length, body[: data_start - 8] + stored + body[data_start:])
        loss = LostSpan(
            "record-length", f"the lengths of the chunk at byte {position} disagree; one of them fits", count=0
        )
        return self._forward(position + HEAD.size + length, [loss, self._noted(record)])

    def _forward(self, position: int, found: Sequence[Record | LostSpan]) -> _Step:
        self._crc = None
        return _Step(found, position, self._bytes_at(position, HEAD.size))

    def _noted(self, record: Record) -> Record:
        self._saw_chunk |= record.opcode == CHUNK_RECORD
        self._saw_message |= record.opcode == MESSAGE_RECORD
        return record

    def _loss(self, start: int, stop: int, code: str) -> LostSpan:
        content = self._bytes_at(start, min(stop - start, SCAN_WINDOW))
        what = "zeros" if not content.strip(b"\0") else "bytes that are no records"
        return LostSpan(code, f"{stop - start} {what} from byte {start} on")

    # reading

    def _unpacked(self, head: bytes) -> tuple[int, int]:
        return HEAD.unpack(head) if len(head) == HEAD.size else (0, 0)

    def _bytes_at(self, position: int, count: int) -> bytes:
        self._stream.seek(position)
        return self._stream.read(max(count, 0))

    def _body(self, position: int, opcode: int, length: int) -> tuple[bytes, bytes]:
        """A record's body and the next record's head."""
        start = position + HEAD.size
        if opcode == ATTACHMENT and length > ATTACHMENT_HEAD_BYTES:
            if self._crc is not None:
                self._feed(position, HEAD.size + length)
            return self._bytes_at(start, ATTACHMENT_HEAD_BYTES), self._bytes_at(start + length, HEAD.size)
        self._stream.seek(start)
        block = self._stream.read(length + HEAD.size)
        if self._crc is not None:
            self._crc = zlib.crc32(HEAD.pack(opcode, length), self._crc)
            self._crc = zlib.crc32(memoryview(block)[:length], self._crc)
        return block[:length], block[length:]

    def _feed(self, position: int, count: int) -> None:
        self._stream.seek(position)
        while count > 0 and self._crc is not None:
            block = self._stream.read(min(count, SCAN_WINDOW))
            self._crc = zlib.crc32(block, self._crc)
            count -= len(block) or count

    # judging places

    def _chunk_fits(self, position: int, length: int) -> bool:
        body = self._bytes_at(position + HEAD.size, PEEK_BYTES)
        return is_record(CHUNK_RECORD, length, body, self._size - position - HEAD.size)

    def _is_chain(self, position: int, further: int) -> bool:
        """Whether a record begins here, and ``further`` ones follow it (or the file's end does)."""
        if position == self._size:
            return True
        opcode, length = self._unpacked(self._bytes_at(position, HEAD.size))
        body = self._bytes_at(position + HEAD.size, PEEK_BYTES)
        room = self._size - position - HEAD.size
        if opcode == 0 or not is_record(opcode, length, body, room):
            return False
        return opcode == DATA_END or further == 0 or self._is_chain(position + HEAD.size + length, further - 1)

    def _next_record(self, start: int) -> int | None:
        """Return the first byte, from ``start`` on, of a record that can be believed; ``None`` where there is none."""
        if self._landmarks.chunks:
            index = bisect_right(self._landmarks.chunks, start - 1)
            return self._landmarks.chunks[index] if index < len(self._landmarks.chunks) else None
        # what lies inside an uncompressed chunk looks like records, but nothing vouches for it
        if self._saw_message and not self._saw_chunk:
            return self._scan(start, _ANY_HEAD)
        found = self._scan(start, _OUTER_HEAD)
        is_chunked = found is not None and self._bytes_at(found, 1)[0] in (CHUNK_RECORD, MESSAGE_INDEX)
        return found if self._saw_chunk or is_chunked else self._scan(start, _ANY_HEAD)

    def _scan(self, start: int, pattern: re.Pattern[bytes]) -> int | None:
        position = start
        while position < self._stop:
            window = self._bytes_at(position, SCAN_WINDOW + HEAD.size)
            for match in pattern.finditer(window):
                candidate = position + match.start()
                if match.start() < SCAN_WINDOW and candidate < self._stop and self._is_chain(candidate, CHAIN):
                    return candidate
            position += SCAN_WINDOW
        return None


def end_of_file(stream: BinaryIO, data_stop: int, size: int) -> int | None:
    """Return where a file ends by its own footer, which may be before its last byte; ``None`` where that is not told.

    Parameters
    ----------
    stream : binary file
    data_stop : int
        Where its data section ends and its summary begins.
    size : int
        Bytes in the file.
    """
    position = data_stop
    while position + FOOTER_BYTES + len(MAGIC) <= size:
        stream.seek(position)
        head = stream.read(FOOTER_BYTES + len(MAGIC))
        opcode, length = HEAD.unpack_from(head)
        if opcode == FOOTER:
            is_whole = length == SHORTEST[FOOTER] and head.endswith(MAGIC)
            return position + len(head) if is_whole else None
        if not is_head(opcode, length, size - position - HEAD.size):
            return None
        position += HEAD.size + length
    return None


def bytes_behind(path: Path, stream: BinaryIO, end: int, size: int) -> str:
    """Return what is said of the bytes that were added behind the end of a file.

    Parameters
    ----------
    path : Path
    stream : binary file
        The same file, opened.
    end : int
        Where the recording ends by its own footer.
    size : int
        Bytes in the file.
    """
    stream.seek(end)
    count, is_other = size - end, stream.read(len(MAGIC)) == MAGIC
    follow, were = agreeing(count, "follows", "follow"), agreeing(count, "was", "were")
    text = f"{counted(count, 'byte')} {follow} the end of the recording at byte {end} and {were} not read"
    if not is_other:
        return f"{text}: {agreeing(count, 'it does', 'they do')} not begin as an MCAP file does"
    parts = (
        f"{shlex.join(command)} > {shlex.quote(str(path.with_name(f'{path.stem}-{number}.mcap')))}"
        for number, command in enumerate(
            (["head", "-c", str(end), str(path)], ["tail", "-c", f"+{end + 1}", str(path)]), 1
        )
    )
    away = shlex.join(["mv", str(path), f"{path}.joined"])
    return (
        f"{text}: they begin as another MCAP file does. Files were joined; split them there: {'; '.join(parts)}; {away}"
    )


@dataclass(frozen=True, slots=True)
class _Step:
    found: Sequence[Record | LostSpan]
    position: int
    head: bytes
