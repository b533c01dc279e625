"""What one MCAP file says of itself, before its messages are read: topics, types, descriptions, landmarks."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, BinaryIO

from mcap.exceptions import McapError
from mcap.records import (
    AttachmentIndex,
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

from tactiledata.contract.lfs_pointer import refuse_lfs_pointer
from tactiledata.contract.records import Finding
from tactiledata.errors import BrokenLog
from tactiledata.formats.mcap.chunks import chunk_content, records_in
from tactiledata.formats.mcap.layout import (
    ATTACHMENT,
    ATTACHMENT_INDEX,
    CHANNEL,
    CHUNK_INDEX,
    CHUNK_RECORD,
    DATA_END,
    DATA_END_BYTES,
    FOOTER,
    FOOTER_BYTES,
    HEAD,
    HEADER,
    MAGIC,
    METADATA,
    METADATA_INDEX,
    SCHEMA,
    STATISTICS,
    parse,
)
from tactiledata.formats.mcap.records import Landmarks, LostSpan, RecordWalker, bytes_behind, end_of_file

COPY_AGAIN = "; what is whole in it is read. Copy it again from where it was recorded"
"""What to do with a file that was cut."""
MAX_SUMMARY_BYTES = 2**29
MAX_METADATA_BYTES = 2**26
TAIL_BYTES = FOOTER_BYTES + len(MAGIC)
RECORD_FAULTS = (McapError, ValueError, EOFError, OverflowError)
"""What the `mcap` package raises on a damaged record."""


@dataclass
class Survey:
    """One file's inventory.

    Parameters
    ----------
    path : Path
    size : int
        Bytes up to the file's own end; what is added behind it is not read.
    schemas, channels : dict by id
    metadata : list of `mcap.records.Metadata`, in file order
    attachments : dict, name -> (offset, length) of the record
    statistics : `mcap.records.Statistics`, optional
        Only from a summary whose CRC fits (or that has none).
    landmarks : Landmarks
    data_crc : int
        The recorded CRC of the data section, 0 where there is none.
    findings : list of Finding
        Of head, summary and footer.
    """

    path: Path
    size: int
    profile: str = ""
    library: str = ""
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    metadata: list[Metadata] = field(default_factory=list)
    attachments: dict[str, tuple[int, int]] = field(default_factory=dict)
    statistics: Statistics | None = None
    landmarks: Landmarks = field(default_factory=Landmarks)
    data_crc: int = 0
    findings: list[Finding] = field(default_factory=list)

    def note(self, code: str, message: str, severity: str = "damage") -> None:
        """Add a finding about this file.

        Parameters
        ----------
        code : str
            Code of the finding.
        message : str
            Its text; the file's name is put before it.
        severity : str
            How bad it is; damage by default.
        """
        self.findings.append(Finding(code, severity, f"{self.path.name}: {message}"))  # type: ignore[arg-type]

    def define(self, opcode: int, body: bytes) -> None:
        """Take a schema or channel record; the first of an id stays, another content is reported."""
        try:
            record: Any = parse(Schema if opcode == SCHEMA else Channel, body)
        except RECORD_FAULTS as error:
            self.note("bad-record", f"a {'schema' if opcode == SCHEMA else 'channel'} record is damaged ({error})")
            return
        known: dict[int, Any] = self.schemas if opcode == SCHEMA else self.channels
        first = known.setdefault(record.id, record)
        if first != record:
            kind = "schema" if opcode == SCHEMA else "channel"
            self.note("conflicting-record", f"{kind} {record.id} is defined twice, differently; the first one is used")


def survey(path: Path) -> Survey:
    """The inventory of an MCAP file, from its summary where that is whole, else by a walk over its data section.

    Raises
    ------
    BrokenLog
        Not an MCAP, empty, or not readable at all.
    """
    refuse_lfs_pointer(path)
    try:
        with path.open("rb") as stream:
            size = path.stat().st_size
            inventory, end = _surveyed(path, stream, size)
            if end is None or end == size:
                return inventory
            inventory, _ = _surveyed(path, stream, end)
            inventory.note("bytes-behind-end", bytes_behind(path, stream, end, size))
            return inventory
    except OSError as error:
        raise BrokenLog(
            f"{path} cannot be read ({error.strerror or error})",
            "a readable file",
            "Check the path and its permissions.",
        ) from error


def _surveyed(path: Path, stream: BinaryIO, size: int) -> tuple[Survey, int | None]:
    """The inventory of the first ``size`` bytes of a file, and where the file ends by its own account, if it tells."""
    inventory = Survey(path, size)
    stream.seek(0)
    _check_magic(inventory, stream)
    if not _read_summary(inventory, stream):
        data_stop = _walk(inventory, stream)
        return inventory, None if data_stop is None else end_of_file(stream, data_stop, size)
    if not inventory.profile:
        _read_header(inventory, stream)
    return inventory, size


def _check_magic(inventory: Survey, stream: BinaryIO) -> None:
    if inventory.size == 0:
        raise BrokenLog(f"{inventory.path} is empty (0 bytes)", "an MCAP file", "Copy the recording again.")
    head = stream.read(len(MAGIC))
    if head == MAGIC:
        return
    stream.seek(max(inventory.size - len(MAGIC), 0))
    if inventory.size < TAIL_BYTES or stream.read(len(MAGIC)) != MAGIC:
        raise BrokenLog(
            f"{inventory.path} begins with {head!r}",
            f"the MCAP magic {MAGIC!r}",
            "Check that it is an MCAP file; other recordings are listed by `tactiledata formats`.",
        )
    inventory.note("bad-magic", "the file's first bytes are damaged; its end is an MCAP's")


def _read_header(inventory: Survey, stream: BinaryIO) -> None:
    stream.seek(len(MAGIC))
    opcode, length = HEAD.unpack(stream.read(HEAD.size).ljust(HEAD.size, b"\0"))
    if opcode == HEADER and length < MAX_METADATA_BYTES:
        _take_header(inventory, stream.read(length))


def _take_header(inventory: Survey, body: bytes) -> None:
    try:
        header = parse(Header, body)
        inventory.profile, inventory.library = header.profile, header.library
    except RECORD_FAULTS as error:
        inventory.note("bad-record", f"the header record is damaged ({error})")


def _read_summary(inventory: Survey, stream: BinaryIO) -> bool:
    """Whether the summary could be read and lists all there is."""
    footer = _footer(inventory, stream)
    if footer is None:
        return False
    if footer.summary_start == 0:
        inventory.landmarks = Landmarks(stop=inventory.size - TAIL_BYTES)
        _read_data_end(inventory, stream, inventory.size - TAIL_BYTES)
        return False
    end = inventory.size - TAIL_BYTES
    if not len(MAGIC) < footer.summary_start <= end or end - footer.summary_start > MAX_SUMMARY_BYTES:
        inventory.note("bad-summary", f"the footer places the summary at byte {footer.summary_start}")
        return False
    stream.seek(footer.summary_start)
    block = stream.read(end - footer.summary_start + FOOTER_BYTES)
    if footer.summary_crc and zlib.crc32(block[:-4]) != footer.summary_crc:
        inventory.note("summary-crc", "the CRC of the summary does not fit; the summary is not used")
        return False
    try:
        return _take_summary(inventory, stream, block[: end - footer.summary_start], footer.summary_start)
    except (*RECORD_FAULTS, BrokenLog) as error:
        inventory.note("bad-summary", f"the summary is damaged ({error}); it is not used")
        inventory.schemas, inventory.channels, inventory.statistics = {}, {}, None
        inventory.landmarks, inventory.attachments, inventory.metadata = Landmarks(), {}, []
        return False


def _footer(inventory: Survey, stream: BinaryIO) -> Footer | None:
    if inventory.size < TAIL_BYTES + len(MAGIC):
        inventory.note("no-footer", f"the file ends before its footer{COPY_AGAIN}")
        return None
    stream.seek(inventory.size - TAIL_BYTES)
    tail = stream.read(TAIL_BYTES)
    opcode, length = HEAD.unpack_from(tail)
    if tail[FOOTER_BYTES:] != MAGIC or opcode != FOOTER or length != FOOTER_BYTES - HEAD.size:
        text = "the file does not end with a footer: it was cut, or something was added behind it"
        inventory.note("no-footer", f"{text}{COPY_AGAIN}")
        return None
    return parse(Footer, tail[HEAD.size : FOOTER_BYTES])


def _read_data_end(inventory: Survey, stream: BinaryIO, stop: int) -> None:
    stream.seek(max(stop - DATA_END_BYTES, 0))
    opcode, length = HEAD.unpack(stream.read(HEAD.size))
    if opcode == DATA_END and length == DATA_END_BYTES - HEAD.size:
        inventory.data_crc = parse(DataEnd, stream.read(length)).data_section_crc


def _take_summary(inventory: Survey, stream: BinaryIO, block: bytes, start: int) -> bool:
    chunks: list[int] = []
    found = Survey(inventory.path, inventory.size)
    metadata: list[MetadataIndex] = []
    for opcode, begin, stop in records_in(block):
        body = block[begin:stop]
        if opcode in (SCHEMA, CHANNEL):
            found.define(opcode, body)
        elif opcode == STATISTICS:
            inventory.statistics = parse(Statistics, body)
        elif opcode == CHUNK_INDEX:
            chunks.append(parse(ChunkIndex, body).chunk_start_offset)
        elif opcode == METADATA_INDEX:
            metadata.append(parse(MetadataIndex, body))
        elif opcode == ATTACHMENT_INDEX:
            inventory.attachments.update(_indexed_attachment(body))
    inventory.schemas, inventory.channels = found.schemas, found.channels
    inventory.findings += found.findings
    _read_data_end(inventory, stream, start)
    stated = inventory.statistics
    is_chunked = bool(chunks) or (bool(stated.chunk_count) if stated and stated.message_count else None)
    has_all_chunks = stated is None or stated.chunk_count == len(chunks)
    inventory.landmarks = Landmarks(tuple(sorted(chunks)) if has_all_chunks else (), start, is_chunked)
    metadata_is_whole = _read_metadata(inventory, stream, metadata)
    return (
        stated is not None
        and metadata_is_whole
        and len(inventory.channels) >= stated.channel_count
        and len(metadata) == stated.metadata_count
        and len(inventory.attachments) == stated.attachment_count
        and all(channel.schema_id in (0, *inventory.schemas) for channel in inventory.channels.values())
    )


def _indexed_attachment(body: bytes) -> dict[str, tuple[int, int]]:
    index = parse(AttachmentIndex, body)
    return {index.name: (index.offset, index.length)}


def _read_metadata(inventory: Survey, stream: BinaryIO, indexes: list[MetadataIndex]) -> bool:
    """Whether all metadata records stand where the summary says."""
    for index in indexes:
        stream.seek(index.offset)
        opcode, length = HEAD.unpack(stream.read(HEAD.size).ljust(HEAD.size, b"\0"))
        if opcode != METADATA or length + HEAD.size != index.length or length > MAX_METADATA_BYTES:
            inventory.metadata = []
            return False
        try:
            inventory.metadata.append(parse(Metadata, stream.read(length)))
        except RECORD_FAULTS:
            inventory.metadata = []
            return False
    return True


def _walk(inventory: Survey, stream: BinaryIO) -> int | None:
    """The inventory from the data section itself, and where that ends, if it is met.

    What is lost there is reported when messages are read.
    """
    data_stop = None
    known = replace(inventory, findings=[], schemas={}, channels={}, metadata=[], attachments={})
    for record in RecordWalker(stream, inventory.size, inventory.landmarks):
        if isinstance(record, LostSpan):
            continue
        if record.opcode == HEADER:
            _take_header(known, record.body)
        elif record.opcode in (SCHEMA, CHANNEL):
            known.define(record.opcode, record.body)
        elif record.opcode == CHUNK_RECORD:
            for opcode, body in _definitions(record.body):
                known.define(opcode, body)
        elif record.opcode == METADATA and record.length <= MAX_METADATA_BYTES:
            _take_metadata(known, record.body)
        elif record.opcode == ATTACHMENT:
            known.attachments.update(_walked_attachment(record.body, record.offset, record.length))
        elif record.opcode == DATA_END:
            data_stop = record.offset + HEAD.size + record.length
            inventory.data_crc = inventory.data_crc or parse(DataEnd, record.body).data_section_crc
    inventory.profile, inventory.library = known.profile, known.library
    inventory.schemas = {**inventory.schemas, **known.schemas}
    inventory.channels = {**inventory.channels, **known.channels}
    inventory.metadata, inventory.attachments = known.metadata, known.attachments
    inventory.findings += known.findings
    return data_stop


def _definitions(body: bytes) -> Iterator[tuple[int, bytes]]:
    try:
        _, content = chunk_content(body)
        for opcode, start, stop in records_in(content):
            if opcode in (SCHEMA, CHANNEL):
                yield opcode, content[start:stop]
    except BrokenLog:
        return  # the reading pass reports it


def _take_metadata(inventory: Survey, body: bytes) -> None:
    try:
        inventory.metadata.append(parse(Metadata, body))
    except RECORD_FAULTS as error:
        inventory.note("bad-record", f"a metadata record is damaged ({error})")


def _walked_attachment(head: bytes, offset: int, length: int) -> dict[str, tuple[int, int]]:
    size = int.from_bytes(head[16:20], "little")
    name = head[20 : 20 + size]
    return {name.decode(errors="replace"): (offset, length + HEAD.size)} if len(name) == size else {}
