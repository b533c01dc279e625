"""Which ROS 2 message a signal becomes: a usual type where there is one, else a type with a field for each column."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tactiledata.arrays import RealArray
from tactiledata.contract import ros2_messages
from tactiledata.contract.ros2_messages import header, typestore
from tactiledata.formats.mcap.readers import UR_JOINTS
from tactiledata.formats.mcap.roles import FIELDS_OF, JOINT_TOPIC, TCP_TOPIC, UR_WRENCH_TOPIC, WRENCH_TOPICS

WRENCH, POSE, JOINTS = "geometry_msgs/msg/WrenchStamped", "geometry_msgs/msg/PoseStamped", "sensor_msgs/msg/JointState"
COMPRESSED, RAW = "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/Image"
KNOWN = {
    "wrench": (f"/{WRENCH_TOPICS[0]}", WRENCH),
    "ur_wrench": (f"/{UR_WRENCH_TOPIC}", WRENCH),
    "tcp": (f"/{TCP_TOPIC}", POSE),
    "joints": (f"/{JOINT_TOPIC}", JOINTS),
    "contact_wrench": ("/tactiledata/contact_wrench", WRENCH),
}
"""Topics and types that viewers and our own reader know."""
WIDTHS = {WRENCH: 6, POSE: 7, JOINTS: 6}
PACKAGE = "tactiledata_msgs/msg"
"""Package of the message types that no standard has: a header and numbers, one type for each set of columns."""
FIELD = re.compile(r"[a-z](_?[a-z0-9])*")
"""Names that ROS 2 allows for a field."""
MakeMessage = Callable[[int, RealArray], bytes]
"""Makes a message from a stamp in ns and its numbers."""


@dataclass(frozen=True)
class MessageType:
    """How a stream is logged.

    Parameters
    ----------
    topic, kind : str
        Name of the topic and of the ROS 2 type.
    definition : bytes
        Text of the type.
    fields : tuple of str
        Paths of the numbers in a message.
    """

    topic: str
    kind: str
    definition: bytes
    fields: tuple[str, ...] = ()

    @property
    def is_own(self) -> bool:
        """Whether no usual type holds the numbers, so that our reader needs a mapping."""
        return self.kind.startswith(PACKAGE)


@cache
def number_type(name: str, columns: tuple[str, ...]) -> MessageType:
    """Return how a signal is logged, by its name in the recording and its columns."""
    topic, kind = KNOWN.get(name, ("", ""))
    if kind and len(columns) == WIDTHS[kind]:
        fields = FIELDS_OF.get(kind.replace("/msg/", "/"), ())
        return MessageType(topic, kind, ros2_messages.definition(kind), tuple(fields))
    store, kind = _own_type(name, columns)
    text, _ = store.generate_msgdef(kind, ros_version=2)
    fields = columns if _are_fields(columns) else tuple(f"values[{place}]" for place in range(len(columns)))
    return MessageType(f"/tactiledata/{name}", kind, text.encode(), fields)


def image_type(camera: str, is_raw: bool) -> MessageType:
    """Return how a camera is logged: as pixels where all its pictures are kept so."""
    plain, kind = camera.replace("/", "_"), RAW if is_raw else COMPRESSED
    topic = f"/{plain}/image_raw" if is_raw else f"/{plain}/image_raw/compressed"
    return MessageType(topic, kind, ros2_messages.definition(kind))


def message_maker(name: str, columns: tuple[str, ...], frame: str) -> MakeMessage:
    """Return what makes the messages of a signal.

    Parameters
    ----------
    name : str
        Of the signal in its recording.
    columns : tuple of str
        Its columns.
    frame : str
        Frame of its vectors.
    """
    kind = number_type(name, columns).kind
    if kind in (WRENCH, POSE):
        make = ros2_messages.wrench if kind == WRENCH else ros2_messages.pose
        return lambda stamp_ns, values: make(stamp_ns, frame, values)
    return partial(_joints if kind == JOINTS else _own_message, name, columns, frame)


def _joints(name: str, columns: Sequence[str], frame: str, stamp_ns: int, values: RealArray) -> bytes:
    """Return a JointState with the names of a UR's joints as CDR bytes."""
    empty = np.zeros(0)
    message = typestore().types[JOINTS](
        header=header(stamp_ns, frame), name=list(UR_JOINTS), position=np.asarray(values, float), velocity=empty,
        effort=empty,
    )  # fmt: skip
    return bytes(typestore().serialize_cdr(message, JOINTS))


def _own_message(name: str, columns: tuple[str, ...], frame: str, stamp_ns: int, values: RealArray) -> bytes:
    """Return a message of a type of our own as CDR bytes."""
    store, kind = _own_type(name, columns)
    numbers: dict[str, Any] = {"values": np.asarray(values, float)}
    if _are_fields(columns):
        numbers = {column: float(value) for column, value in zip(columns, values, strict=True)}
    message = store.types[kind](header=header(stamp_ns, frame), **numbers)
    return bytes(store.serialize_cdr(message, kind))


@cache
def _own_type(name: str, columns: tuple[str, ...]) -> tuple[Any, str]:
    """Return message types with one for these columns, and its name."""
    words = re.findall(r"[A-Za-z0-9]+", name)
    kind = f"{PACKAGE}/{''.join(word[:1].upper() + word[1:] for word in ['values', *words])}"
    fields = "".join(f"float64 {column}\n" for column in columns) if _are_fields(columns) else "float64[] values\n"
    # a table of its own: two recordings may mean other columns by the same name
    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(f"std_msgs/Header header\n{fields}", kind))
    return store, kind


def _are_fields(columns: Sequence[str]) -> bool:
    """Whether columns can be fields of a message, beside its header."""
    return all(FIELD.fullmatch(column) for column in columns) and "header" not in columns
