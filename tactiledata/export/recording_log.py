"""One recording as an MCAP file of ROS 2 messages: topics, types, and messages in the order of their log times."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, BinaryIO

import numpy as np
from mcap.writer import CompressionType, Writer
from numpy.typing import NDArray
from rosbags.typesys import get_types_from_msg

from tactiledata.arrays import RealArray
from tactiledata.contract import ros2_messages
from tactiledata.contract.ros2_messages import header, repeated, typestore
from tactiledata.errors import StoreError
from tactiledata.formats.mcap.readers import UR_JOINTS
from tactiledata.formats.mcap.roles import JOINT_TOPIC, TCP_TOPIC, UR_WRENCH_TOPIC, WRENCH_TOPICS

LIBRARY = "tactiledata"
CHUNK_BYTES = 4 * 2**20
WRENCH, POSE, JOINTS = "geometry_msgs/msg/WrenchStamped", "geometry_msgs/msg/PoseStamped", "sensor_msgs/msg/JointState"
COMPRESSED, RAW = "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/Image"
VALUES = "tactiledata_msgs/msg/Values"
VALUES_TEXT = "std_msgs/Header header\nstring[] columns\nstring[] units\nfloat64[] values\n"
"""A type of our own for numbers that no usual message type holds."""
KNOWN = {
    "wrench": (f"/{WRENCH_TOPICS[0]}", WRENCH),
    "ur_wrench": (f"/{UR_WRENCH_TOPIC}", WRENCH),
    "tcp": (f"/{TCP_TOPIC}", POSE),
    "joints": (f"/{JOINT_TOPIC}", JOINTS),
    "contact_wrench": ("/tactiledata/contact_wrench", WRENCH),
}
"""Topics and types that viewers and our own reader know."""
WIDTHS = {WRENCH: 6, POSE: 7, JOINTS: 6}
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
    topic, kind : str
        Name and ROS 2 type.
    log_ns, publish_ns : (n,) int64
        Stamps of the messages.
    messages : callable
        Gives functions that make the bytes, one for each message, in order.
    """

    topic: str
    kind: str
    log_ns: NDArray[np.int64]
    publish_ns: NDArray[np.int64]
    messages: Callable[[], Iterator[Callable[[], bytes]]]


@cache
def _own_type() -> None:
    """Let rosbags know our own type of message."""
    typestore().register(get_types_from_msg(VALUES_TEXT, VALUES))


def topic_of(name: str, columns: Sequence[str]) -> tuple[str, str]:
    """Return topic and type under which a signal is logged.

    Parameters
    ----------
    name : str
        Of the signal in its recording.
    columns : sequence of str
        Its columns; a usual name with unusual columns is logged as plain values.
    """
    topic, kind = KNOWN.get(name, ("", ""))
    if kind and len(columns) == WIDTHS[kind]:
        return topic, kind
    return f"/tactiledata/{name}", VALUES


def image_topic(camera: str, is_raw: bool) -> tuple[str, str]:
    """Return topic and type under which a camera is logged."""
    plain = camera.replace("/", "_")
    return (f"/{plain}/image_raw", RAW) if is_raw else (f"/{plain}/image_raw/compressed", COMPRESSED)


def number_message(
    kind: str, frame: str, columns: Sequence[str], units: Sequence[str], stamp_ns: int, values: RealArray
) -> bytes:
    """Return one message of numbers as CDR bytes.

    Parameters
    ----------
    kind : str
        ROS 2 type.
    frame : str
        Frame of vectors.
    columns, units : sequence of str
        What the numbers are, where the type does not say it.
    stamp_ns : int
        Stamp of the header; 0 for none.
    values : (k,)
        The numbers, SI units.
    """
    if kind == WRENCH:
        return ros2_messages.wrench(stamp_ns, frame, values)
    if kind == POSE:
        return ros2_messages.pose(stamp_ns, frame, values)
    numbers = np.asarray(values, np.float64)
    if kind == JOINTS:
        empty = np.zeros(0)
        fields: dict[str, Any] = {"name": list(UR_JOINTS), "position": numbers, "velocity": empty, "effort": empty}
    else:
        _own_type()
        fields = {"columns": list(columns), "units": list(units), "values": numbers}
    message = typestore().types[kind](header=header(stamp_ns, frame), **fields)
    return bytes(typestore().serialize_cdr(message, kind))


def number_stream(
    topic: str,
    kind: str,
    make: Callable[[int, RealArray], bytes],
    stamps: Mapping[str, NDArray[np.int64]],
    values: RealArray,
) -> LoggedStream:
    """Return a stream of numbers.

    Parameters
    ----------
    topic, kind : str
        Name and ROS 2 type.
    make : callable
        Makes a message from a stamp and numbers.
    stamps : dict of (n,) int64
        ``log``, ``publish`` and ``header``, ns; -1 where there is none.
    values : (n, k)
        The numbers.
    """
    order = np.argsort(stamps["log"], kind="stable")
    log_ns, publish_ns, header_ns = (stamps[name][order] for name in ("log", "publish", "header"))

    def messages() -> Iterator[Callable[[], bytes]]:
        """Yield a function for each message."""
        message = repeated(make, np.maximum(header_ns, 0), values[order])
        return (partial(message, index) for index in range(len(order)))

    return LoggedStream(topic, kind, log_ns, np.where(publish_ns < 0, log_ns, publish_ns), messages)


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
    first = min((int(each.log_ns[0]) for each in streams if len(each.log_ns)), default=0)
    for name, content in sorted(attachments.items()):
        writer.add_attachment(first, first, name, "image/png", content)
    for name, texts in metadata.items():
        writer.add_metadata(name, dict(texts))
    schemas: dict[str, int] = {}
    channels = []
    for each in streams:
        if each.kind == VALUES:
            _own_type()
        if each.kind not in schemas:
            schemas[each.kind] = writer.register_schema(each.kind, "ros2msg", ros2_messages.definition(each.kind))
        channels.append(writer.register_channel(each.topic, "cdr", schemas[each.kind]))
    merged = heapq.merge(*(_messages(number, each) for number, each in enumerate(streams)))
    for log_ns, number, sequence, make in merged:
        publish_ns = int(streams[number].publish_ns[sequence])
        writer.add_message(channels[number], log_ns, make(), publish_ns, sequence)
    writer.finish()


def _messages(number: int, stream: LoggedStream) -> Iterator[Message]:
    """Yield the messages of a stream in the order of their log times."""
    for sequence, (log_ns, make) in enumerate(zip(stream.log_ns.tolist(), stream.messages(), strict=True)):
        yield log_ns, number, sequence, make


def _require_times(streams: Sequence[LoggedStream], where: str) -> None:
    for each in streams:
        for stamps in (each.log_ns, each.publish_ns):
            if len(stamps) and (stamps.min() < 0 or stamps.max() >= LARGEST_STAMP):
                raise StoreError(
                    f"{where}: {each.topic} has times from {stamps.min()} to {stamps.max()} ns",
                    "times from 1970 to 2038, as MCAP and ROS 2 hold them",
                    "Correct the clock in the recording's mapping (`clock`), and ingest it again with --replace.",
                )
