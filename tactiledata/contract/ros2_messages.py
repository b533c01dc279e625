"""ROS 2 messages as CDR bytes, many at a time: rosbags makes one of a kind, and numbers in it are replaced."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_typestore

from tactiledata.arrays import RealArray

STAMP_AT = 4
"""Position, in bytes, of the header's stamp: after the four bytes of encapsulation, before everything else."""


@cache
def typestore() -> Any:
    """Return the message types of ROS 2 Humble."""
    return get_typestore(Stores.ROS2_HUMBLE)


def definition(kind: str) -> bytes:
    """Return the schema text of a message type, as rosbag2 puts it into an MCAP."""
    text, _ = typestore().generate_msgdef(kind, ros_version=2)
    return text.encode()


def header(stamp_ns: int, frame: str) -> Any:
    """Return a message header with a time stamp, ns, and the name of a frame."""
    types = typestore().types
    stamp = types["builtin_interfaces/msg/Time"](sec=int(stamp_ns // 10**9), nanosec=int(stamp_ns % 10**9))
    return types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def wrench(stamp_ns: int, frame: str, values: RealArray) -> bytes:
    """Return a WrenchStamped message as CDR bytes.

    Parameters
    ----------
    stamp_ns : int
        Time stamp, ns.
    frame : str
        Frame of force and torque.
    values : (6,), N and N m
        Force, then torque.
    """
    types, kind = typestore().types, "geometry_msgs/msg/WrenchStamped"
    vector = types["geometry_msgs/msg/Vector3"]
    numbers = [float(value) for value in values]
    content = types["geometry_msgs/msg/Wrench"](force=vector(*numbers[:3]), torque=vector(*numbers[3:]))
    message = types[kind](header=header(stamp_ns, frame), wrench=content)
    return bytes(typestore().serialize_cdr(message, kind))


def pose(stamp_ns: int, frame: str, values: RealArray) -> bytes:
    """Return a PoseStamped message as CDR bytes.

    Parameters
    ----------
    stamp_ns : int
        Time stamp, ns.
    frame : str
        Frame in which the pose is stated.
    values : (7,), m
        Position, then a quaternion x y z w.
    """
    types, kind = typestore().types, "geometry_msgs/msg/PoseStamped"
    numbers = [float(value) for value in values]
    content = types["geometry_msgs/msg/Pose"](
        position=types["geometry_msgs/msg/Point"](*numbers[:3]),
        orientation=types["geometry_msgs/msg/Quaternion"](*numbers[3:]),
    )
    message = types[kind](header=header(stamp_ns, frame), pose=content)
    return bytes(typestore().serialize_cdr(message, kind))


def repeated(
    make: Callable[[int, RealArray], bytes], stamp_ns: NDArray[np.int64], rows: RealArray
) -> Callable[[int], bytes]:
    """Return a function that gives the CDR bytes of a message by its row number, all made from one.

    Parameters
    ----------
    make : callable
        Makes a message, whose first field is a header, from a stamp in ns and its numbers (k,), each kept as float64.
    stamp_ns : (n,), ns
        Time stamps.
    rows : (n, k)
        Numbers of the messages.
    """
    # numbers that occur nowhere else mark the places of the fields in a message made by rosbags
    marks = 1.0e300 + 1.0e290 * np.arange(rows.shape[1])
    template = make(0, marks)
    places = [template.index(mark.tobytes()) for mark in marks]
    block = np.tile(np.frombuffer(template, np.uint8), (len(rows), 1))
    block[:, STAMP_AT : STAMP_AT + 4] = _bytes_of(stamp_ns // 10**9, "<i4")
    block[:, STAMP_AT + 4 : STAMP_AT + 8] = _bytes_of(stamp_ns % 10**9, "<u4")
    for column, place in enumerate(places):
        block[:, place : place + 8] = _bytes_of(rows[:, column], "<f8")
    return lambda index: block[index].tobytes()


def _bytes_of(values: NDArray[Any], kind: str) -> NDArray[np.uint8]:
    """Return the bytes (n, size) of numbers (n,) of a kind, for example ``"<f8"``."""
    fixed = np.ascontiguousarray(values.astype(kind))
    return fixed.view(np.uint8).reshape(len(fixed), -1)


def compressed_image(stamp_ns: int, frame: str, encoding: str, payload: bytes) -> bytes:
    """Return a CompressedImage message as CDR bytes.

    Parameters
    ----------
    stamp_ns : int
        Time stamp, ns.
    frame : str
        Name of the camera's frame.
    encoding : str
        Format of the payload, ``jpeg`` or ``png``.
    payload : bytes
        The encoded picture.
    """
    kind = "sensor_msgs/msg/CompressedImage"
    message = typestore().types[kind](
        header=header(stamp_ns, frame), format=encoding, data=np.frombuffer(payload, np.uint8)
    )
    return bytes(typestore().serialize_cdr(message, kind))


def raw_image(stamp_ns: int, frame: str, channels: str, height: int, width: int, payload: bytes) -> bytes:
    """Return an Image message of three channels of eight bits as CDR bytes.

    Parameters
    ----------
    stamp_ns : int
        Time stamp, ns.
    frame : str
        Name of the camera's frame.
    channels : str
        Stated order of the channels, ``rgb8`` or ``bgr8``.
    height, width : int
        Size in pixels.
    payload : bytes
        The pixels, row by row.
    """
    kind = "sensor_msgs/msg/Image"
    message = typestore().types[kind](
        header=header(stamp_ns, frame),
        height=height,
        width=width,
        encoding=channels,
        is_bigendian=0,
        step=3 * width,
        data=np.frombuffer(payload, np.uint8),
    )
    return bytes(typestore().serialize_cdr(message, kind))
