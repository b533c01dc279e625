"""Fast reading of the ROS 2 messages that come by the hundred per second.

Each reader is the twin of a general one (`readers`), for little-endian CDR and exactly the usual layout; anything else
raises `ValueError`, and the general reader takes the message. A test holds both to the same values.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from operator import itemgetter
from typing import Any

from tactiledata.formats.mcap.collect import SignalBuffer

Take = Callable[[bytes, int, int, int, int], None]
"""Buffer, start and stop of the payload, log time, publish time."""

_HEADER = struct.Struct("<HHiII")
"""Encapsulation (two bytes kind, two bytes options), seconds, nanoseconds, length of frame_id with its end."""
_COUNT = struct.Struct("<I")
LITTLE_ENDIAN_CDR = 0x0100
_HEADER_LAYOUT = (("header.stamp.sec", "int32"), ("header.stamp.nanosec", "uint32"), ("header.frame_id", "string"))


def _doubles(*paths: str) -> tuple[tuple[str, str], ...]:
    return tuple((path, "float64") for path in paths)


VECTOR_LAYOUTS = {
    (
        *_HEADER_LAYOUT,
        *_doubles(*(f"wrench.{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz")),
    ): 6,
    (
        *_HEADER_LAYOUT,
        *_doubles(*(f"pose.position.{axis}" for axis in "xyz"), *(f"pose.orientation.{axis}" for axis in "xyzw")),
    ): 7,
}
"""Layouts that are a header and so many doubles."""
JOINT_LAYOUT = (
    *_HEADER_LAYOUT,
    ("name", "string[]"),
    ("position", "float64[]"),
    ("velocity", "float64[]"),
    ("effort", "float64[]"),
)


def header_at(buffer: bytes, start: int, stop: int) -> tuple[int, bytes, int]:
    """Stamp in ns, frame_id, and where the next field may begin, counted from the encapsulation's end.

    Parameters
    ----------
    buffer : bytes
        A chunk or file that the message lies in.
    start, stop : int
        First byte of the message, and the byte after its last.

    Raises
    ------
    ValueError
        The message does not begin with a header in little-endian CDR.
    """
    if stop - start < _HEADER.size:
        raise ValueError("shorter than a header")
    kind, _, sec, nanosec, size = _HEADER.unpack_from(buffer, start)
    after = start + _HEADER.size + size
    if kind != LITTLE_ENDIAN_CDR or size == 0 or after > stop or buffer[after - 1] != 0:
        raise ValueError("not a little-endian CDR header")
    return sec * 1_000_000_000 + nanosec, buffer[start + _HEADER.size : after - 1], _HEADER.size - 4 + size


def vector_taker(count: int, sink: SignalBuffer) -> Take:
    """A reader of a header and ``count`` doubles."""
    doubles = struct.Struct(f"<{count}d")
    frames: dict[bytes, str] = {}
    add = sink.add

    def take(buffer: bytes, start: int, stop: int, log_ns: int, publish_ns: int) -> None:
        stamp, frame, offset = header_at(buffer, start, stop)
        place = start + 4 + (offset + 7 & ~7)
        if not 0 <= stop - place - doubles.size < 4:
            raise ValueError("another length")
        if frame not in frames:
            frames[frame] = frame.decode()
        add(doubles.unpack_from(buffer, place), log_ns, publish_ns, stamp, frames[frame])

    return take


def joint_taker(order: Callable[[tuple[str, ...]], tuple[int, ...] | None], sink: SignalBuffer) -> Take:
    """A reader of joint positions.

    Parameters
    ----------
    order : callable
        Joint names of a message -> places of our joints among them; ``None``: it holds none, and is skipped.
    """
    block, doubles = b"", struct.Struct("")
    pick: Any = None
    frames: dict[bytes, str] = {}
    is_known = False

    def take(buffer: bytes, start: int, stop: int, log_ns: int, publish_ns: int) -> None:
        nonlocal block, pick, doubles, is_known
        stamp, frame, offset = header_at(buffer, start, stop)
        place = start + 4 + (offset + 3 & ~3)
        if not is_known or buffer[place : place + len(block)] != block:
            names, block = _names_at(buffer, place, stop)
            indexes = order(names)
            is_known = indexes is not None
            if indexes is None:
                return
            if min(indexes) < 0:
                is_known = False
                raise ValueError("joints are missing")
            pick, doubles = itemgetter(*indexes), struct.Struct(f"<{len(names)}d")
        count, values, place = _doubles_at(buffer, start, place + len(block), stop)
        if count * 8 != doubles.size:
            raise ValueError("another number of positions than names")
        _, _, place = _doubles_at(buffer, start, place, stop)
        _, _, place = _doubles_at(buffer, start, place, stop)
        if stop - place >= 4:
            raise ValueError("another length")
        if frame not in frames:
            frames[frame] = frame.decode()
        sink.add(pick(doubles.unpack_from(buffer, values)), log_ns, publish_ns, stamp, frames[frame])

    return take


def _doubles_at(buffer: bytes, start: int, place: int, stop: int) -> tuple[int, int, int]:
    """How many doubles a sequence has, where they begin, and where it ends; an empty one has no padding."""
    place = start + 4 + (place - start - 4 + 3 & ~3)
    if place + 4 > stop:
        raise ValueError("numbers that end early")
    (count,) = _COUNT.unpack_from(buffer, place)
    if not count:
        return 0, place + 4, place + 4
    begin = start + 4 + (place - start + 7 & ~7)
    end = begin + 8 * count
    if end > stop:
        raise ValueError("numbers that end early")
    return count, begin, end


def _names_at(buffer: bytes, place: int, stop: int) -> tuple[tuple[str, ...], bytes]:
    """The names of a sequence of strings, and its bytes."""
    begin = place
    if place + 4 > stop:
        raise ValueError("no names")
    (count,) = struct.unpack_from("<I", buffer, place)
    place += 4
    if count > (stop - place) // 5:
        raise ValueError("more names than bytes")
    names = []
    for _ in range(count):
        place = begin + (place - begin + 3 & ~3)
        if place + 4 > stop:
            raise ValueError("names that end early")
        (size,) = struct.unpack_from("<I", buffer, place)
        place += 4 + size
        if size == 0 or place > stop:
            raise ValueError("a name that ends early")
        names.append(buffer[place - size : place - 1].decode())
    return tuple(names), buffer[begin:place]


# images: header fields of the message, the pixels stay where they are

COMPRESSED_LAYOUT = (*_HEADER_LAYOUT, ("format", "string"), ("data", "uint8[]"))
IMAGE_LAYOUT = (
    *_HEADER_LAYOUT,
    ("height", "uint32"),
    ("width", "uint32"),
    ("encoding", "string"),
    ("is_bigendian", "uint8"),
    ("step", "uint32"),
    ("data", "uint8[]"),
)


def compressed_at(buffer: bytes, start: int, stop: int) -> tuple[int, str, str, bytes]:
    """Stamp, frame_id, format and bytes of a sensor_msgs/CompressedImage.

    Parameters
    ----------
    buffer : bytes
        A chunk or file that the message lies in.
    start, stop : int
        First byte of the message, and the byte after its last.

    Raises
    ------
    ValueError
        The message is shorter than it says, or in another encoding.
    """
    stamp, frame, offset = header_at(buffer, start, stop)
    style, offset = _string_at(buffer, start, stop, offset)
    return stamp, frame.decode(), style, _bytes_at(buffer, start, stop, offset)


def image_at(buffer: bytes, start: int, stop: int) -> tuple[int, str, str, int, int, int, bytes]:
    """Stamp, frame_id, encoding, height, width, step and bytes of a sensor_msgs/Image.

    Parameters
    ----------
    buffer : bytes
        A chunk or file that the message lies in.
    start, stop : int
        First byte of the message, and the byte after its last.

    Raises
    ------
    ValueError
        The message is shorter than it says, or in another encoding.
    """
    stamp, frame, offset = header_at(buffer, start, stop)
    offset = offset + 3 & ~3
    if start + 4 + offset + 8 > stop:
        raise ValueError("an image that ends early")
    height, width = struct.unpack_from("<II", buffer, start + 4 + offset)
    style, offset = _string_at(buffer, start, stop, offset + 8)
    offset = offset + 1 + 3 & ~3  # is_bigendian means nothing for 8-bit pixels
    if start + 4 + offset + 4 > stop:
        raise ValueError("an image that ends early")
    (step,) = struct.unpack_from("<I", buffer, start + 4 + offset)
    return stamp, frame.decode(), style, height, width, step, _bytes_at(buffer, start, stop, offset + 4)


def _string_at(buffer: bytes, start: int, stop: int, offset: int) -> tuple[str, int]:
    place = start + 4 + (offset + 3 & ~3)
    if place + 4 > stop:
        raise ValueError("a text that ends early")
    (size,) = struct.unpack_from("<I", buffer, place)
    after = place + 4 + size
    if size == 0 or after > stop or buffer[after - 1] != 0:
        raise ValueError("a text that ends early")
    return buffer[place + 4 : after - 1].decode(), after - start - 4


def _bytes_at(buffer: bytes, start: int, stop: int, offset: int) -> bytes:
    place = start + 4 + (offset + 3 & ~3)
    if place + 4 > stop:
        raise ValueError("pixels that end early")
    (size,) = struct.unpack_from("<I", buffer, place)
    if not 0 <= stop - place - 4 - size < 4:
        raise ValueError("another number of bytes")
    return buffer[place + 4 : place + 4 + size]
