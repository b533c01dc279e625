"""Which topic is what: by a mapping, else by the names and types that drivers use.

A guess is made only where a name says it: UR's own wrist sensor and the Robotiq have the same message type, and taking
one for the other would spoil every force after it.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from tactiledata.contract.records import Finding
from tactiledata.errors import SchemaError
from tactiledata.formats.mcap.message_fields import steps_of
from tactiledata.formats.reading.described import camera_topics
from tactiledata.formats.reading.natural_order import natural_key
from tactiledata.units import FIELDS, SIGNAL_COLUMNS

WRENCH_TOPICS = ("robotiq_force_torque_sensor_broadcaster/wrench", "robotiq_ft_wrench", "robotiq_ft_sensor")
"""In the order in which they are preferred; the last one has no header."""
UR_WRENCH_TOPIC = "force_torque_sensor_broadcaster/wrench"
TCP_TOPIC = "tcp_pose_broadcaster/pose"
JOINT_TOPIC = "joint_states"
TACTILE_WORDS = ("digit", "gelsight", "tactile")
ONLY_CAMERA = "camera"
"""Name of the camera of the only image topic, where nothing in the topic's name says tactile."""

FIELDS_OF = {
    "geometry_msgs/WrenchStamped": tuple(f"wrench.{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz"),
    "geometry_msgs/Wrench": tuple(f"{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz"),
    "robotiq_ft_sensor/ft_sensor": ("Fx", "Fy", "Fz", "Mx", "My", "Mz"),
    "geometry_msgs/PoseStamped": (
        *(f"pose.position.{axis}" for axis in "xyz"),
        *(f"pose.orientation.{axis}" for axis in "xyzw"),
    ),
    "geometry_msgs/Pose": (*(f"position.{axis}" for axis in "xyz"), *(f"orientation.{axis}" for axis in "xyzw")),
    "geometry_msgs/TransformStamped": (
        *(f"transform.translation.{axis}" for axis in "xyz"),
        *(f"transform.rotation.{axis}" for axis in "xyzw"),
    ),
    "foxglove.PoseInFrame": (
        *(f"pose.position.{axis}" for axis in "xyz"),
        *(f"pose.orientation.{axis}" for axis in "xyzw"),
    ),
}
"""Where the numbers of a type lie that is a whole signal."""
KINDS_OF_SIGNAL = {
    "wrench": ("geometry_msgs/WrenchStamped", "geometry_msgs/Wrench", "robotiq_ft_sensor/ft_sensor"),
    "ur_wrench": ("geometry_msgs/WrenchStamped", "geometry_msgs/Wrench"),
    "tcp": (
        "geometry_msgs/PoseStamped",
        "geometry_msgs/Pose",
        "geometry_msgs/TransformStamped",
        "foxglove.PoseInFrame",
        "tf2_msgs/TFMessage",
    ),
    "joints": ("sensor_msgs/JointState",),
}
TF_KIND = "tf2_msgs/TFMessage"
ROTATION_VECTOR_UNITS = ("m", "m", "m", "rad", "rad", "rad")
"""Columns of a pose as UR controllers give it: position and rotation vector."""
COLUMNS_OF = {**SIGNAL_COLUMNS, "ur_wrench": SIGNAL_COLUMNS["wrench"]}
RAW_KINDS = ("sensor_msgs/Image", "foxglove.RawImage")
COMPRESSED_KINDS = ("sensor_msgs/CompressedImage", "foxglove.CompressedImage")
IMAGE_KINDS = (*RAW_KINDS, *COMPRESSED_KINDS)


@dataclass(frozen=True)
class Topic:
    """A topic of a recording, as its channels state it."""

    name: str
    kind: str
    is_readable: bool = True


@dataclass(frozen=True)
class SignalRole:
    """A topic that is read as a signal.

    Parameters
    ----------
    name, topic : str
    columns, units : names
    fields : tuple of str
        Paths inside a message; empty where the type says it (wrench, tcp, joints).
    frame : str, optional
        The frame_id that is meant.
    child_frame : str
        The moving frame, where the topic carries a tree of transforms.
    joint_names : tuple of str
        Joints by name, base to wrist; empty for the usual names of a UR.
    static_topic : str
        The topic of the fixed transforms of a tree, where there is one.
    is_rotation_vector : bool
        Whether the fields of a tcp are a position and a rotation vector, which becomes a quaternion.
    """

    name: str
    topic: str
    columns: tuple[str, ...]
    units: tuple[str, ...] = ()
    fields: tuple[str, ...] = ()
    frame: str | None = None
    child_frame: str = ""
    joint_names: tuple[str, ...] = ()
    static_topic: str = ""
    is_rotation_vector: bool = False

    @property
    def field_units(self) -> tuple[str, ...]:
        """Units that the fields have to be brought to; those that the mapping states where nobody else knows."""
        if self.is_rotation_vector:
            return ROTATION_VECTOR_UNITS
        stated = self.units or ("?",) * len(self.columns)
        return tuple(FIELDS[c].unit if c in FIELDS else unit for c, unit in zip(self.columns, stated, strict=True))

    @property
    def is_tree(self) -> bool:
        """Whether the topic carries a tree of transforms, of which the pose between two frames is meant."""
        return bool(self.child_frame) and not self.fields


@dataclass(frozen=True)
class ImageRole:
    """A topic that is read as a camera.

    Parameters
    ----------
    camera, topic, sensor, channel_order : str
        As a mapping names them.
    data : tuple
        Steps to the field with an encoded picture, in messages whose type is no picture's.
    """

    camera: str
    topic: str
    sensor: str = ""
    channel_order: str = ""
    data: tuple[str | int, ...] = ()


@dataclass(frozen=True)
class Roles:
    """What is read from a recording, topic by topic, and what was found on the way."""

    signals: tuple[SignalRole, ...] = ()
    images: tuple[ImageRole, ...] = ()
    findings: tuple[Finding, ...] = ()
    notes: Mapping[str, str] = field(default_factory=dict)

    def label(self, topic: str, empty: Container[str] = ()) -> str:
        """What a topic is read as: ``wrench``, ``image:digit``; empty where it is not read.

        ``empty`` are names of its signals and cameras that got no message: it is not read as these.
        """
        names = [role.name for role in self.signals if role.topic == topic and role.name not in empty]
        names += [f"{role.name} (fixed transforms)" for role in self.signals if role.static_topic == topic]
        names += [f"image:{role.camera}" for role in self.images if role.topic == topic and role.camera not in empty]
        return ", ".join(names)

    @property
    def topics(self) -> set[str]:
        """All topics that are read."""
        signals = {topic for role in self.signals for topic in (role.topic, role.static_topic) if topic}
        return signals | {role.topic for role in self.images}


def ends_with(topic: str, ending: str) -> bool:
    """Whether a topic is this one, possibly below a namespace."""
    return f"/{topic.strip('/')}".endswith(f"/{ending}")


def is_fixed_tree(topic: str) -> bool:
    """Whether a topic carries the fixed transforms of a tree."""
    return topic.endswith("tf_static")


def roles_of(topics: Iterable[Topic], mapping: Mapping[str, Any] | None = None) -> Roles:
    """The roles of a recording's topics: those that a mapping names, and guesses for what it leaves out.

    A mapping that names cameras names all of them.

    Raises
    ------
    SchemaError
        A mapping that a recording's types contradict.
    """
    known = sorted(topics, key=lambda topic: natural_key(topic.name))
    document = mapping or {}
    findings: list[Finding] = []
    notes: dict[str, str] = {}
    signals = [
        role
        for name, entry in document.get("signals", {}).items()
        if (role := _mapped_signal(name, entry, known, findings)) is not None
    ]
    taken = {role.name for role in signals} | set(document.get("signals", {}))
    mapped_topics = {topic for role in signals for topic in (role.topic, role.static_topic)}
    signals += _guessed_signals([topic for topic in known if topic.name not in mapped_topics], taken, notes)
    if "images" in document:
        images = [
            camera_role
            for camera, entry in document["images"].items()
            if (camera_role := _mapped_camera(camera, entry, known, findings)) is not None
        ]
        pictures = [topic.name for topic in known if topic.kind in IMAGE_KINDS]
        if document["images"] and not images and pictures:
            findings.append(
                Finding(
                    "pictures-not-mapped",
                    "damage",
                    f"no camera of the mapping is in this recording, so that its pictures on {', '.join(pictures)} are "
                    "not kept",
                )
            )
    else:
        images = _guessed_cameras(known, notes)
    return Roles(tuple(signals), tuple(images), tuple(findings), notes)


# what a mapping names


def _found(topic: str, known: list[Topic], place: str, findings: list[Finding]) -> Topic | None:
    for candidate in known:
        if candidate.name == topic or candidate.name.strip("/") == topic.strip("/"):
            return candidate
    near = difflib.get_close_matches(topic, [candidate.name for candidate in known], n=3)
    hint = f"; did you mean {' or '.join(near)}?" if near else ""
    findings.append(
        Finding("missing-topic", "warning", f"the mapping's {place} names {topic}, which is not there{hint}")
    )
    return None


def _refuse_array_keys(entry: Mapping[str, Any], place: str) -> None:
    for key in ("time", "time_unit"):
        if key in entry:
            raise SchemaError(
                f"the mapping's {place} has {key}, which is for arrays in HDF5 files",
                "no such key: messages carry their times",
                "Write a mapping of its own for HDF5 files.",
                path=f"$.{place}.{key}",
            )


def _mapped_signal(
    name: str, entry: Mapping[str, Any], known: list[Topic], findings: list[Finding]
) -> SignalRole | None:
    place = f"signals.{name}"
    _refuse_array_keys(entry, place)
    fields = tuple(entry.get("fields", ()))
    columns = COLUMNS_OF.get(name, fields)
    try:
        for path in fields:
            steps_of(path)
    except ValueError as error:
        raise SchemaError(f"the mapping's {place}: {error}", "a path such as pose.position.x or effort[2]",
                          path=f"$.{place}.fields") from error  # fmt: skip
    if not columns:
        raise SchemaError(f"the mapping's {place} has no fields", "fields: paths of numbers inside a message",
                          "Only wrench, tcp and joints are known without them.", path=f"$.{place}")  # fmt: skip
    is_rotation_vector = entry.get("rotation") == "rotation_vector"
    if "rotation" in entry and (name != "tcp" or not fields):
        raise SchemaError(f"the mapping's {place} states a rotation", "only for tcp, beside 'fields'", "Remove it.",
                          path=f"$.{place}.rotation")  # fmt: skip
    wanted = ("x", "y", "z", "rx", "ry", "rz") if is_rotation_vector else columns
    if fields and len(fields) != len(wanted):
        remedy = "A pose with a rotation vector says so: rotation: rotation_vector." if name == "tcp" else ""
        raise SchemaError(f"the mapping's {place} has {len(fields)} fields", f"{len(wanted)}: {', '.join(wanted)}",
                          remedy, path=f"$.{place}")  # fmt: skip
    units = tuple("1" if unit == 1 else unit for unit in entry.get("units", ()))  # YAML reads a bare 1 as a number
    if units and len(units) != len(wanted):
        raise SchemaError(f"the mapping's {place} has {len(units)} units", f"{len(wanted)}", path=f"$.{place}.units")
    topic = _found(entry["topic"], known, place, findings)
    if topic is None:
        return None
    if not fields and topic.kind not in KINDS_OF_SIGNAL.get(name, ()):
        raise SchemaError(
            f"the mapping's {place} names {topic.name} of type {topic.kind or 'unknown'}",
            f"one of {', '.join(KINDS_OF_SIGNAL.get(name, ()))}, or 'fields' that say where the numbers are",
            "`tactiledata inspect` shows a message of every topic.",
            path=f"$.{place}.topic",
        )
    if topic.kind == TF_KIND and not fields and not (entry.get("child_frame") and entry.get("frame")):
        raise SchemaError(
            f"the mapping's {place} reads {topic.name}, a tree of transforms",
            "'frame' and 'child_frame': between which two frames the pose is meant",
            path=f"$.{place}",
        )
    if units and not fields:
        fields = FIELDS_OF.get(topic.kind, ())
        wanted_units = tuple(FIELDS[column].unit for column in columns)
        if not fields and units != wanted_units:
            raise SchemaError(
                f"the mapping's {place} states units for {topic.name} ({topic.kind}), which are not applied to it",
                f"none, or {', '.join(wanted_units)}",
                "'fields' beside 'units' say which numbers they are of.",
                path=f"$.{place}.units",
            )
    static = ""
    if topic.kind == TF_KIND:
        fixed = [one.name for one in known if one.kind == TF_KIND and one.is_readable and is_fixed_tree(one.name)]
        static = next((name for name in fixed if name == f"{topic.name}_static"), fixed[0] if len(fixed) == 1 else "")
    return SignalRole(
        name, topic.name, columns, units, fields, entry.get("frame"), entry.get("child_frame", ""),
        tuple(entry.get("joint_names", ())), "" if static == topic.name else static, is_rotation_vector,
    )  # fmt: skip


def _mapped_camera(
    camera: str, entry: Mapping[str, Any], known: list[Topic], findings: list[Finding]
) -> ImageRole | None:
    place = f"images.{camera}"
    _refuse_array_keys(entry, place)
    names = camera_topics(entry)
    there = [topic for topic in known if topic.name.strip("/") in {name.strip("/") for name in names}]
    if len(there) > 1:
        raise SchemaError(
            f"the mapping's {place} lists {' and '.join(topic.name for topic in there)}: one recording has all of them",
            "a list of topics of which each recording has one",
            "Make a camera of each.",
            path=f"$.{place}.topic",
        )
    topic = there[0] if there else _found(" or ".join(names), known, place, findings)
    if topic is None:
        return None
    data = _picture_field(entry, place)
    if topic.kind not in IMAGE_KINDS and not data:
        raise SchemaError(
            f"the mapping's {place} names {topic.name} of type {topic.kind or 'unknown'}",
            f"one of {', '.join(IMAGE_KINDS)}, or 'data': the path of the field that holds a JPEG or PNG",
            path=f"$.{place}.topic",
        )
    return ImageRole(camera, topic.name, entry.get("sensor", ""), entry.get("channel_order", ""), data)


def _picture_field(entry: Mapping[str, Any], place: str) -> tuple[str | int, ...]:
    """Steps to the field that a camera's entry names as its picture; none where it names none."""
    if "data" not in entry:
        return ()
    if "channel_order" in entry:
        raise SchemaError(f"the mapping's {place} states a channel_order beside 'data'", "one of the two",
                          "A picture's own bytes say its colours.", path=f"$.{place}.channel_order")  # fmt: skip
    try:
        return steps_of(entry["data"])
    except ValueError as error:
        raise SchemaError(f"the mapping's {place}: {error}", "a path such as frame.jpeg",
                          path=f"$.{place}.data") from error  # fmt: skip


# guesses


def _guessed_signals(known: list[Topic], taken: set[str], notes: dict[str, str]) -> list[SignalRole]:
    found = []
    for name, endings in (("wrench", WRENCH_TOPICS), ("tcp", (TCP_TOPIC,)), ("joints", (JOINT_TOPIC,))):
        if name in taken:
            continue
        kinds = KINDS_OF_SIGNAL[name]
        for ending in endings:
            fits = [topic for topic in known if topic.kind in kinds and ends_with(topic.name, ending)]
            usable = [topic for topic in fits if topic.is_readable]
            if len(usable) > 1:
                listed = " and ".join(topic.name for topic in usable)
                for topic in usable:
                    notes[topic.name] = f"{listed} could each be {name}: a mapping must say which one is meant"
                break
            if usable:
                found.append(SignalRole(name, usable[0].name, COLUMNS_OF[name]))
                break
    ur = [
        topic
        for topic in known
        if topic.kind in KINDS_OF_SIGNAL["ur_wrench"] and ends_with(topic.name, UR_WRENCH_TOPIC)
    ]
    if len(ur) == 1 and ur[0].is_readable and "ur_wrench" not in taken:
        found.append(SignalRole("ur_wrench", ur[0].name, COLUMNS_OF["ur_wrench"]))
        notes[ur[0].name] = "the robot's own wrist sensor, not the Robotiq; a mapping can name it as wrench"
    named = {role.topic for role in found}
    for topic in known:
        if topic.kind in FIELDS_OF and topic.name not in named:
            notes.setdefault(topic.name, "not read: its name is none that is known; a mapping can name it")
        elif topic.kind == TF_KIND:
            notes.setdefault(topic.name, "a tree of transforms; a mapping can read tcp from it (frame, child_frame)")
    return found


def _guessed_cameras(known: list[Topic], notes: dict[str, str]) -> list[ImageRole]:
    images = _one_per_camera([topic for topic in known if topic.kind in IMAGE_KINDS and topic.is_readable], notes)
    tactile = [topic for topic in images if _tactile_word(topic.name)]
    chosen = tactile or (images if len(images) == 1 else [])
    for topic in images:
        if topic not in chosen:
            notes[topic.name] = (
                "an image topic that is not read: nothing in its name says tactile; a mapping can name it"
            )
    counts: dict[str, int] = {}
    roles = []
    for topic in chosen:
        word = _tactile_word(topic.name) or ONLY_CAMERA
        counts[word] = counts.get(word, 0) + 1
        roles.append(ImageRole(word if counts[word] == 1 else f"{word}_{counts[word]}", topic.name))
    return roles


def _tactile_word(topic: str) -> str:
    return next((word for word in TACTILE_WORDS if word in topic.lower()), "")


def _one_per_camera(images: list[Topic], notes: dict[str, str]) -> list[Topic]:
    """Raw images rather than compressed ones where both of one camera were recorded."""
    raw = {topic.name for topic in images if topic.kind in RAW_KINDS}
    kept = []
    for topic in images:
        base = re.sub(r"/compressed$", "", topic.name)
        if base != topic.name and base in raw:
            notes[topic.name] = f"the same pictures as {base}, which is read because it is lossless"
        else:
            kept.append(topic)
    return kept
