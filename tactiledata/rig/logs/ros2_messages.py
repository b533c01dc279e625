"""ROS 2 messages as CDR bytes, many at a time: rosbags makes one of a kind, and numbers in it are replaced."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_typestore

from tactiledata.arrays import RealArray
from tactiledata.rig.motion.ur5e import JOINT_NAMES

STAMP_AT = 4
"""Position, in bytes, of the header's stamp: after the four bytes of encapsulation, before everything else."""
DRIVER_ORDER = (1, 2, 3, 4, 5, 0)
"""The order in which the UR driver publishes joints: the shoulder pan comes last. Readers must go by name."""
FRAMES = {"joints": "base_link", "tcp": "base", "wrench": "robotiq_ft_frame_id", "arm_wrench": "tool0"}
KINDS = {
    "joints": "sensor_msgs/msg/JointState",
    "tcp": "geometry_msgs/msg/PoseStamped",
    "wrench": "geometry_msgs/msg/WrenchStamped",
    "arm_wrench": "geometry_msgs/msg/WrenchStamped",
}
TOPICS = {
    "joints": "/joint_states",
    "tcp": "/tcp_pose_broadcaster/pose",
    "wrench": "/robotiq_force_torque_sensor_broadcaster/wrench",
    "arm_wrench": "/force_torque_sensor_broadcaster/wrench",
}


@cache
def typestore() -> Any:
    """Return the message types of ROS 2 Humble."""
    return get_typestore(Stores.ROS2_HUMBLE)


def definition(kind: str) -> bytes:
    """Return the schema text of a message type, as rosbag2 puts it into an MCAP."""
    text, _ = typestore().generate_msgdef(kind, ros_version=2)
    return text.encode()


def _header(stamp_ns: int, frame: str) -> Any:
    """Return a message header with a time stamp, ns, and the name of a frame."""
    types = typestore().types
    stamp = types["builtin_interfaces/msg/Time"](sec=int(stamp_ns // 10**9), nanosec=int(stamp_ns % 10**9))
    return types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def _message(stream: str, stamp_ns: int, row: RealArray) -> Any:
    """Return one message of a stream of numbers, from a row as `wire_values` gives it."""
    types = typestore().types
    header = _header(stamp_ns, FRAMES[stream])
    if stream == "joints":
        return types[KINDS[stream]](
            header=header,
            name=[JOINT_NAMES[joint] for joint in DRIVER_ORDER],
            position=np.array(row[:6]),
            velocity=np.array(row[6:]),
            effort=np.zeros(0),
        )
    vector, point = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Point"]
    values = [float(value) for value in row]
    if stream == "tcp":
        pose = types["geometry_msgs/msg/Pose"](
            position=point(*values[:3]), orientation=types["geometry_msgs/msg/Quaternion"](*values[3:])
        )
        return types[KINDS[stream]](header=header, pose=pose)
    wrench = types["geometry_msgs/msg/Wrench"](force=vector(*values[:3]), torque=vector(*values[3:]))
    return types[KINDS[stream]](header=header, wrench=wrench)


def wire_values(stream: str, stamp_ns: NDArray[np.int64], values: RealArray) -> RealArray:
    """Return the numbers of each message (n, k) in the order of its fields.

    Joints come in the driver's order, followed by their velocities.

    Parameters
    ----------
    stream : str
        ``joints``, ``tcp``, ``wrench`` or ``arm_wrench``.
    stamp_ns : (n,), ns
        Stamps, which decide the velocities.
    values : (n, k)
        Samples of the stream, SI units.
    """
    if stream != "joints" or not len(values):
        return values
    seconds = (stamp_ns - stamp_ns[0]) * 1e-9
    velocity = np.gradient(values, seconds, axis=0) if len(values) > 1 else np.zeros_like(values)
    order = list(DRIVER_ORDER)
    return np.concatenate([values[:, order], velocity[:, order]], axis=1)


def serialise_slowly(stream: str, stamp_ns: int, row: RealArray) -> bytes:
    """Return one message as CDR bytes, made by rosbags itself: the slow twin of `serialise`, for tests.

    Parameters
    ----------
    stream : str
        Name of the stream.
    stamp_ns : int
        Time stamp, ns.
    row : (k,)
        Numbers as `wire_values` gives them.
    """
    return bytes(typestore().serialize_cdr(_message(stream, stamp_ns, row), KINDS[stream]))


def serialise(stream: str, stamp_ns: NDArray[np.int64], values: RealArray) -> Callable[[int], bytes]:
    """Return a function that gives the CDR bytes of a stream's message by its row number.

    Parameters
    ----------
    stream : str
        Name of the stream.
    stamp_ns : (n,), ns
        Time stamps.
    values : (n, k)
        Samples of the stream, SI units.
    """
    rows = wire_values(stream, stamp_ns, values)
    # numbers that occur nowhere else mark the places of the fields in a message made by rosbags
    marks = 1.0e300 + 1.0e290 * np.arange(rows.shape[1])
    template = serialise_slowly(stream, 0, marks)
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
        header=_header(stamp_ns, frame), format=encoding, data=np.frombuffer(payload, np.uint8)
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
        header=_header(stamp_ns, frame),
        height=height,
        width=width,
        encoding=channels,
        is_bigendian=0,
        step=3 * width,
        data=np.frombuffer(payload, np.uint8),
    )
    return bytes(typestore().serialize_cdr(message, kind))
