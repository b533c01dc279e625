"""Streams of the rig as ROS 2 messages: topics, types, frames, and the order in which drivers publish joints."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.contract.ros2_messages import (
    compressed_image,
    definition,
    header,
    pose,
    raw_image,
    repeated,
    typestore,
    wrench,
)
from tactiledata.rig.motion.ur5e import JOINT_NAMES

__all__ = ["compressed_image", "definition", "raw_image", "typestore"]

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
    if stream != "joints":
        return (pose if stream == "tcp" else wrench)(stamp_ns, FRAMES[stream], row)
    message = typestore().types[KINDS[stream]](
        header=header(stamp_ns, FRAMES[stream]),
        name=[JOINT_NAMES[joint] for joint in DRIVER_ORDER],
        position=np.array(row[:6]),
        velocity=np.array(row[6:]),
        effort=np.zeros(0),
    )
    return bytes(typestore().serialize_cdr(message, KINDS[stream]))


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
    return repeated(partial(serialise_slowly, stream), stamp_ns, wire_values(stream, stamp_ns, values))
