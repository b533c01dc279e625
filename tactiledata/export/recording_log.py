"""One recording as an MCAP file of ROS 2 messages: topics, types, and messages in the order of their log times."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import BinaryIO

from mcap.writer import CompressionType, Writer

from tactiledata.arrays import RealArray
from tactiledata.contract.ros2_messages import repeated
from tactiledata.errors import StoreError
from tactiledata.export.message_types import MakeMessage, MessageType
from tactiledata.export.recorded_streams import RecordedStamps

LIBRARY = "tactiledata"
CHUNK_BYTES = 4 * 2**20
LARGEST_STAMP = 2**31 * 10**9
"""ROS 2 counts the seconds of a stamp in 32 bits."""
IMAGES_AT_ONCE = 16

Message = tuple[int, int, int, Callable[[], bytes]]
"""Log time in ns, stream number, sequence number, and a function that gives the bytes."""


@dataclass(frozen=True)
class LoggedStream:
    """A topic, and its messages in the order of their log times.

    Parameters
    ----------
    type : MessageType
    stamps : RecordedStamps
    messages : callable
        Gives functions that make the bytes, one for each message, in order.
    """

    type: MessageType
    stamps: RecordedStamps
    messages: Callable[[], Iterator[Callable[[], bytes]]]


def number_stream(kind: MessageType, make: MakeMessage, stamps: RecordedStamps, values: RealArray) -> LoggedStream:
    """Return a stream of numbers.

    Parameters
    ----------
    kind : MessageType
        How it is logged.
    make : callable
        Makes a message from a stamp and numbers.
    stamps : RecordedStamps
        Of n messages.
    values : (n, k)
        The numbers.
    """
    order, stamps = stamps.ordered()

    def messages() -> Iterator[Callable[[], bytes]]:
        """Yield a function for each message."""
        message = repeated(make, stamps.header_ns, values[order])
        return (partial(message, index) for index in range(len(order)))

    return LoggedStream(kind, stamps, messages)


def write_log(
    stream: BinaryIO, streams: Sequence[LoggedStream], metadata: Mapping[str, Mapping[str, str]],
    attachments: Mapping[str, bytes], where: str,
) -> None:  # fmt: skip
    """Write an MCAP file with chunks, an index and CRCs.

    Parameters
    ----------
    stream : file
        Open for writing.
    streams : sequence of LoggedStream
        All topics.
    metadata : dict of dict
        Records of texts by name, written first.
    attachments : dict of bytes
        PNG files by name.
    where : str
        The recording, for messages.

    Raises
    ------
    StoreError
        A time that an MCAP file or a ROS 2 stamp cannot hold.
    """
    _require_times(streams, where)
    writer = Writer(stream, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD, enable_crcs=True)
    writer.start(profile="ros2", library=LIBRARY)
    # first, so that a file that is cut still says what it is
    first = min((int(each.stamps.log_ns[0]) for each in streams if len(each.stamps.log_ns)), default=0)
    for name, content in sorted(attachments.items()):
        writer.add_attachment(first, first, name, "image/png", content)
    for name, texts in metadata.items():
        writer.add_metadata(name, dict(texts))
    schemas: dict[str, int] = {}
    channels = []
    for each in streams:
        kind = each.type.kind
        if kind not in schemas:
            schemas[kind] = writer.register_schema(kind, "ros2msg", each.type.definition)
        channels.append(writer.register_channel(each.type.topic, "cdr", schemas[kind]))
    merged = heapq.merge(*(_messages(number, each) for number, each in enumerate(streams)))
    for log_ns, number, sequence, make in merged:
        publish_ns = int(streams[number].stamps.publish_ns[sequence])
        writer.add_message(channels[number], log_ns, make(), publish_ns, sequence)
    writer.finish()


def _messages(number: int, stream: LoggedStream) -> Iterator[Message]:
    """Yield the messages of a stream in the order of their log times."""
    for sequence, (log_ns, make) in enumerate(zip(stream.stamps.log_ns.tolist(), stream.messages(), strict=True)):
        yield log_ns, number, sequence, make


def _require_times(streams: Sequence[LoggedStream], where: str) -> None:
    for each in streams:
        for times in (each.stamps.log_ns, each.stamps.publish_ns, each.stamps.header_ns):
            if len(times) and (times.min() < 0 or times.max() >= LARGEST_STAMP):
                raise StoreError(
                    f"{where}: {each.type.topic} has times from {times.min()} to {times.max()} ns",
                    "times from 1970 to 2038, as MCAP and ROS 2 hold them",
                    "Correct the clock in the recording's mapping (`clock`), and ingest it again with --replace.",
                )
