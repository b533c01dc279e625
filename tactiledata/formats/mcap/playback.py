"""The messages of one file, handed to whoever wants them; what was lost on the way becomes findings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace

from mcap.records import Channel, Schema

from tactiledata.contract.records import Finding, Severity
from tactiledata.contract.wording import agreeing, counted
from tactiledata.errors import BrokenLog
from tactiledata.formats.mcap.chunks import read_ahead
from tactiledata.formats.mcap.layout import (
    CHANNEL,
    HEAD,
    MESSAGE,
    MESSAGE_FIELDS,
    MESSAGE_INDEX,
    MESSAGE_RECORD,
    SCHEMA,
    ChunkHead,
    chunk_head,
)
from tactiledata.formats.mcap.records import LostSpan, Record, RecordWalker
from tactiledata.formats.mcap.survey import Survey

Handler = Callable[[bytes, int, int, int, int], None]
"""Takes a buffer, where the message's payload starts and stops in it, its log time and its publish time (ns)."""
HandlerFor = Callable[[Channel, Schema | None], Handler | None]


class Playback:
    """One pass over one file.

    Parameters
    ----------
    inventory : Survey
    handler_for : callable
        Channel and schema -> a `Handler`, or ``None`` for messages that nobody wants.

    Attributes
    ----------
    messages : int
        Messages met, wanted or not.
    first_ns, last_ns : int, optional
        Log times of the first and last message met.
    """

    def __init__(self, inventory: Survey, handler_for: HandlerFor) -> None:
        self._inventory = inventory
        self._handler_for = handler_for
        self._handlers: dict[int, Handler | None] = {}
        self._unknown: Counter[int] = Counter()
        self._losses: list[LostSpan] = []
        self._open: list[int] = []
        self._bad_times = 0
        self._chunks_without_crc = 0
        self._chunks = 0
        self._bare_messages = 0
        self.messages = 0
        self.first_ns: int | None = None
        self.last_ns: int | None = None

    def run(self) -> list[Finding]:
        """All messages to their handlers; returns what was found about the file, its survey's findings included."""
        inventory = self._inventory
        for channel in inventory.channels.values():
            self._handlers[channel.id] = self._handler_for(channel, inventory.schemas.get(channel.schema_id))
        with inventory.path.open("rb") as stream:
            walker = RecordWalker(stream, inventory.size, inventory.landmarks, with_crc=bool(inventory.data_crc))
            bad_chunk: LostSpan | None = None
            for record, content in read_ahead(walker):
                if bad_chunk is not None:
                    if isinstance(record, Record) and record.opcode == MESSAGE_INDEX:
                        bad_chunk = _with_indexed(bad_chunk, record.body)
                        continue
                    self._lose(bad_chunk)
                    bad_chunk = None
                if isinstance(record, LostSpan):
                    self._lose(record)
                elif content is not None:
                    bad_chunk = self._play_chunk(record, content)
                else:
                    self._play_outer(record)
            if bad_chunk is not None:
                self._lose(bad_chunk)
        return [*inventory.findings, *self._file_findings(walker), *self._loss_findings()]

    # messages

    def _play_outer(self, record: Record) -> None:
        if record.opcode == MESSAGE_RECORD:
            self._bare_messages += 1
            self._drain(HEAD.pack(record.opcode, record.length) + record.body)
        elif record.opcode in (SCHEMA, CHANNEL):
            self._define(record.opcode, record.body)

    def _play_chunk(self, record: Record, content: tuple[ChunkHead, bytes] | BrokenLog) -> LostSpan | None:
        """A chunk's messages to their handlers, or what is lost with it."""
        self._chunks += 1
        if isinstance(content, BrokenLog):
            stated = chunk_head(record.body)
            span = (None, None) if stated is None else (stated.start_ns, stated.end_ns)
            where = f"{content.found} at byte {record.offset}"
            return LostSpan(content.facts["code"], where, *_plausible_span(*span))
        head, messages = content
        self._chunks_without_crc += head.crc == 0
        try:
            self._drain(messages)
        except BrokenLog as fault:
            self._lose(LostSpan(fault.facts["code"], f"{fault.found} (chunk at byte {record.offset})"))
        return None

    def _drain(self, content: bytes) -> None:
        """The messages of a chunk (or a single one), in order; the loop that every message goes through."""
        handlers, unpack, head_size, message_size = self._handlers, MESSAGE.unpack_from, HEAD.size, MESSAGE.size
        position, end, count = 0, len(content), 0
        log = None
        try:
            while position < end:
                if position + message_size > end:
                    position = self._drain_short(content, position)
                    continue
                opcode, length, channel, _, log_ns, publish_ns = unpack(content, position)
                start = position + head_size
                stop = start + length
                if stop > end:
                    raise BrokenLog(f"a record of {length} bytes that leaves its chunk", code="chunk-content")
                position = stop
                if opcode != MESSAGE_RECORD:
                    self._define(opcode, content[start:stop])
                    continue
                if length < MESSAGE_FIELDS or log_ns < 0:
                    self._bad_times += 1
                    continue
                count += 1
                if log is None and (self._open or self.first_ns is None):
                    self._begin(log_ns)
                log = log_ns
                try:
                    handler = handlers[channel]
                except KeyError:
                    self._unknown[channel] += 1
                    continue
                if handler is not None:
                    handler(content, start + MESSAGE_FIELDS, stop, log_ns, publish_ns)
        finally:
            self.messages += count
            self.last_ns = self.last_ns if log is None else log

    def _drain_short(self, content: bytes, position: int) -> int:
        """Past a record that is shorter than a message's fixed fields."""
        start = position + HEAD.size
        if start > len(content):
            raise BrokenLog(f"{len(content) - position} bytes too many in a chunk", code="chunk-content")
        opcode, length = HEAD.unpack_from(content, position)
        if start + length > len(content):
            raise BrokenLog(f"a record of {length} bytes that leaves its chunk", code="chunk-content")
        self._define(opcode, content[start : start + length])
        return start + length

    def _define(self, opcode: int, body: bytes) -> None:
        """A schema or channel of the data section that the survey has not met."""
        if opcode not in (SCHEMA, CHANNEL):
            return
        inventory = self._inventory
        known = (set(inventory.schemas), set(inventory.channels))
        inventory.define(opcode, body)
        for identity in set(inventory.channels) - known[1]:
            channel = inventory.channels[identity]
            self._handlers[identity] = self._handler_for(channel, inventory.schemas.get(channel.schema_id))

    # losses

    def _begin(self, log_ns: int) -> None:
        """The first message after a loss: it bounds the span that was lost."""
        if self.first_ns is None:
            self.first_ns = log_ns
        for index in self._open:
            self._losses[index] = replace(self._losses[index], end_ns=log_ns)
        self._open.clear()

    def _lose(self, loss: LostSpan) -> None:
        if loss.start_ns is None:
            loss = replace(loss, start_ns=self.last_ns)
        if loss.end_ns is None:
            self._open.append(len(self._losses))
        self._losses.append(loss)

    def _loss_findings(self) -> list[Finding]:
        losses, missing = self._counted()
        name = self._inventory.path.name
        found = [
            Finding(
                loss.code,
                "damage",
                f"{name}: {loss.message}; {_amount(loss.count)}",
                start_ns=loss.start_ns,
                end_ns=loss.end_ns,
                count=loss.count or 1,
            )
            for loss in losses
        ]
        if missing:
            found.append(
                self._finding(
                    "messages-missing",
                    f"{counted(missing, 'message')} of its statistics {agreeing(missing, 'was', 'were')} not met",
                    missing,
                )
            )
        return found

    def _counted(self) -> tuple[list[LostSpan], int]:
        """The losses with their numbers of messages, and how many more the file's statistics miss."""
        stated = self._inventory.statistics
        losses = list(self._losses)
        if stated is None:
            return losses, 0
        missing = stated.message_count - self.messages - self._bad_times - sum(loss.count or 0 for loss in losses)
        unknown = [index for index, loss in enumerate(losses) if loss.count is None]
        if unknown and missing >= 0:
            if len(unknown) == 1 or missing == 0:
                for index in unknown:
                    losses[index] = replace(losses[index], count=missing)
                return losses, 0
            return losses, missing
        return losses, max(missing, 0)

    def _file_findings(self, walker: RecordWalker) -> list[Finding]:
        stated = self._inventory.data_crc
        found = []
        if self._bad_times:
            were = agreeing(self._bad_times, "was", "were")
            text = f"{counted(self._bad_times, 'message')} with impossible log times {were} left out"
            found.append(self._finding("bad-stamp", text, self._bad_times))
        for channel, count in sorted(self._unknown.items()):
            text = (
                f"{counted(count, 'message')} of channel {channel}, whose record is missing: topic and type are unknown"
            )
            found.append(self._finding("unknown-channel", text, count))
        if walker.data_crc is not None and walker.data_crc != stated:
            text = "the CRC of the data section does not fit, and nothing says which record is damaged"
            found.append(self._finding("data-crc", text, self.messages))
        unvouched = self._chunks_without_crc or (self._bare_messages if not self._chunks else 0)
        if unvouched and not (stated and walker.data_crc == stated):
            what = "chunks" if self._chunks_without_crc else "messages outside chunks"
            text = f"{unvouched} {what} without CRC: their content is unverified"
            found.append(self._finding("crc-not-recorded", text, unvouched, "info"))
        return found

    def _finding(self, code: str, text: str, count: int, severity: Severity = "damage") -> Finding:
        text = f"{self._inventory.path.name}: {text}"
        return Finding(code, severity, text, start_ns=self.first_ns, end_ns=self.last_ns, count=max(count, 1))


def _with_indexed(loss: LostSpan, body: bytes) -> LostSpan:
    """The loss of a chunk, with the messages that the index record behind it lists."""
    return replace(loss, count=(loss.count or 0) + (len(body) - 6) // 16)


def _plausible_span(start: int | None, end: int | None) -> tuple[int | None, int | None]:
    return (start, end) if start is not None and end is not None and 0 < start <= end < 2**63 else (None, None)


def _amount(count: int | None) -> str:
    if count is None:
        return "how many messages are lost is unknown"
    return f"{count} message{'' if count == 1 else 's'} lost" if count else "no message is lost"
