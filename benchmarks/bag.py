"""A ROS 2 MCAP as a UR5e with a DIGIT and a Robotiq FT 300-S records it: real types, real rates, zstd chunks, CRCs."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from digit_frames import COLUMNS, ROWS, digit_frames, encoded
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

START_NS = 1_700_000_000_000_000_000
JOINTS = ["elbow_joint", "shoulder_lift_joint", "shoulder_pan_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
TOPICS = {
    "joints": ("/joint_states", "sensor_msgs/msg/JointState", 500.0),
    "tcp": ("/tcp_pose_broadcaster/pose", "geometry_msgs/msg/PoseStamped", 125.0),
    "wrench": ("/robotiq_force_torque_sensor_broadcaster/wrench", "geometry_msgs/msg/WrenchStamped", 100.0),
}
PRESS_S = 5.0
"""One press and release takes this long."""


def write_bag(path: Path, seconds: float, n_images: int, *, raw: bool) -> None:
    """An MCAP of ``seconds``, with ``n_images`` DIGIT images as JPEG or raw, presses of up to 8 N in between."""
    types = get_typestore(Stores.ROS2_HUMBLE)
    image_type = "sensor_msgs/msg/Image" if raw else "sensor_msgs/msg/CompressedImage"
    image_topic = "/digit/image_raw" if raw else "/digit/image_raw/compressed"
    streams = [_stamped(name, kind, _messages(types, name, rate, seconds)) for name, (_, kind, rate) in TOPICS.items()]
    streams.append(_stamped("image", image_type, _images(types, seconds, n_images, raw=raw)))
    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library="tactiledata benchmark")
        topics = {**{name: topic for name, (topic, _, _) in TOPICS.items()}, "image": image_topic}
        channels: dict[str, int] = {}
        for number, (t_ns, name, kind, message) in enumerate(_by_time(streams)):
            if name not in channels:
                text = types.generate_msgdef(kind, ros_version=2)[0]
                schema = writer.register_schema(kind, "ros2msg", text.encode())
                channels[name] = writer.register_channel(topics[name], "cdr", schema)
            payload = bytes(types.serialize_cdr(message, kind))
            writer.add_message(channels[name], t_ns + 200_000, payload, t_ns + 100_000, number)
        writer.finish()


def _stamped(name: str, kind: str, messages: Iterator[tuple[int, Any]]) -> Iterator[tuple[int, str, str, Any]]:
    return ((t_ns, name, kind, message) for t_ns, message in messages)


def _by_time(streams: list[Iterator[tuple[int, str, str, Any]]]) -> Iterator[tuple[int, str, str, Any]]:
    heads = [(next(stream), stream) for stream in streams]
    while heads:
        place = min(range(len(heads)), key=lambda index: heads[index][0][0])
        head, stream = heads[place]
        yield head
        following = next(stream, None)
        heads = [*heads[:place], *([] if following is None else [(following, stream)]), *heads[place + 1 :]]


def _press(t: float) -> float:
    """Normal force in newtons: presses with free air between."""
    return 8.0 * max(0.0, np.sin(2 * np.pi * t / PRESS_S)) ** 1.5


def _messages(types: Any, name: str, rate: float, seconds: float) -> Iterator[tuple[int, Any]]:
    rng = np.random.default_rng(len(name))
    kinds = types.types
    vector, quaternion = kinds["geometry_msgs/msg/Vector3"], kinds["geometry_msgs/msg/Quaternion"]
    point, pose = kinds["geometry_msgs/msg/Point"], kinds["geometry_msgs/msg/Pose"]
    wrench = kinds["geometry_msgs/msg/Wrench"]
    for index in range(int(seconds * rate)):
        t_ns = START_NS + round(index * 1e9 / rate)
        t, noise = index / rate, rng.standard_normal(6)
        frame = {"wrench": "robotiq_ft_frame_id", "tcp": "base", "joints": ""}[name]
        head = _header(types, t_ns, frame)
        if name == "joints":
            angles = np.array([1.0, -1.5, 0.2, -1.0, -1.57, 0.0]) + 1e-3 * noise
            yield t_ns, kinds[TOPICS[name][1]](head, JOINTS, angles, 0.1 * noise, noise)
        elif name == "tcp":
            depth = 1.2e-4 * _press(t)
            position = point(0.4 + 1e-6 * noise[0], -0.1 + 1e-6 * noise[1], 0.2 - depth)
            yield t_ns, kinds[TOPICS[name][1]](head, pose(position, quaternion(0.0, 1.0, 0.0, 0.0)))
        else:
            force = vector(0.1 * noise[0], 0.1 * noise[1], -_press(t) + 0.1 * noise[2])
            torque = vector(*(0.005 * noise[3:]))
            yield t_ns, kinds[TOPICS[name][1]](head, wrench(force, torque))


def _images(types: Any, seconds: float, n_images: int, *, raw: bool) -> Iterator[tuple[int, Any]]:
    for index, picture in enumerate(itertools.islice(digit_frames(n_images), n_images)):
        t_ns = START_NS + round(index * seconds * 1e9 / n_images)
        head = _header(types, t_ns, "digit_D20542")
        if raw:
            content = picture[:, :, ::-1].reshape(-1)
            message = types.types["sensor_msgs/msg/Image"](head, ROWS, COLUMNS, "bgr8", 0, COLUMNS * 3, content)
        else:
            content = np.frombuffer(encoded(picture, ".jpg"), np.uint8)
            message = types.types["sensor_msgs/msg/CompressedImage"](head, "jpeg", content)
        yield t_ns, message


def _header(types: Any, t_ns: int, frame: str) -> Any:
    stamp = types.types["builtin_interfaces/msg/Time"](t_ns // 10**9, t_ns % 10**9)
    return types.types["std_msgs/msg/Header"](stamp, frame)
