"""A mapping to start from: what is read now, what could be read, and what only a person knows, clearly marked."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import yaml

from tactiledata.contract.description import PLACEHOLDER, LogDescription
from tactiledata.formats.mcap.message_fields import path_of
from tactiledata.formats.mcap.readers import JointOrder
from tactiledata.formats.mcap.roles import (
    IMAGE_KINDS,
    KINDS_OF_SIGNAL,
    ONLY_CAMERA,
    TACTILE_WORDS,
    TF_KIND,
    Roles,
    SignalRole,
    Topic,
    is_fixed_tree,
)
from tactiledata.formats.mcap.unread_topics import (
    HOW_TO_UNCOMMENT,
    Glimpse,
    UnreadTopics,
    entry_text,
    on_one_line,
    picture_fields,
    unread_topics,
)
from tactiledata.formats.reading.described import camera_topics
from tactiledata.formats.reading.natural_order import natural_key

LIKELY_WORDS = {"wrench": ("robotiq", "ft300"), "tcp": ("tcp", "tool"), "joints": ("joint_states",)}
"""Words in a topic's name that put it first among several that could be a signal."""

LIKELY_FRAMES = (("base", "base_link", "world"), ("tool0_controller", "tcp", "tool0", "flange"))
"""Names of a robot's base and of its moving end, the likeliest first."""

MAX_ALTERNATIVES = 5

NOT_SAID = "nothing in the topic's name says tactile: remove it where it is no tactile sensor"

STATE_MORE = """\
# What else the recording may not say of itself goes under `description:` too (docs/formats-folder.md), for example:
#   robot: {tcp_from_gel: {xyz: [0, 0, 0.2]}, tcp_from_ft: {xyz: [0, 0, 0]}, tool: {mass: 0.5}}
#   wrench: {sign: load_on_sensor, gravity: included}
"""
STATE_ALL = """\
# What the recordings may not say of themselves goes under `description:` (docs/formats-folder.md), for example:
# description:
#   sensors: {SERIAL: {model: digit}}  # of each camera; needed where there is a description
#   robot: {tcp_from_gel: {xyz: [0, 0, 0.2]}, tcp_from_ft: {xyz: [0, 0, 0]}, tool: {mass: 0.5}}
#   wrench: {sign: load_on_sensor, gravity: included}
"""


@dataclass(frozen=True)
class Draft:
    """A mapping as a document that fits its schema, and as text with remarks and alternatives in comments."""

    document: dict[str, Any]
    text: str


@dataclass
class _Entry:
    content: dict[str, Any]
    remark: str = ""
    instead: list[tuple[dict[str, Any], str]] = field(default_factory=list)


def draft_mapping(
    topics: Iterable[Topic],
    roles: Roles,
    glimpses: Mapping[str, Glimpse],
    serials: Mapping[str, Sequence[str]],
    description: LogDescription,
    one_camera: Sequence[str] = (),
    of_cameras: Mapping[str, Sequence[str]] | None = None,
) -> Draft:
    """A mapping that reads what is read now, and lists every other topic with what it holds and how to read it.

    Parameters
    ----------
    topics : iterable of Topic
    roles : Roles
        What is read now.
    glimpses : dict, topic -> Glimpse
    serials : dict, topic -> serials
        Of image topics whose sensor the recordings name; several where they name different ones.
    description : LogDescription
        What the recordings say of themselves.
    one_camera : sequence of str
        Topics of which each recording has one, and no other camera: they are one camera of the mapping.
    of_cameras : dict, camera -> topics
        Of cameras that a mapping gives several topics, of which each recording has one.
    """
    ordered = sorted(topics, key=lambda topic: natural_key(topic.name))
    known = [topic for topic in ordered if topic.is_readable]
    signals = {role.name: _Entry(_role_entry(role, glimpses)) for role in roles.signals}
    for name in ("wrench", "tcp", "joints"):
        if name not in signals and (entry := _candidates(name, known, roles, glimpses)) is not None:
            signals[name] = entry
    images, sensors = _images(known, roles, serials, description, glimpses, one_camera, of_cameras or {})
    document: dict[str, Any] = {"format": "tactiledata-mapping/1"}
    entries = {"signals": signals, "images": images}
    document |= {title: {name: e.content for name, e in listed.items()} for title, listed in entries.items() if listed}
    if sensors:
        document["description"] = {"sensors": sensors}
    unread = unread_topics((topic for topic in ordered if topic.name not in _named(roles, entries)), glimpses, entries)
    return Draft(document, _draft_text(document, entries, unread))


def _named(roles: Roles, entries: Mapping[str, Mapping[str, _Entry]]) -> set[str]:
    """Topics that the draft reads or offers as an alternative."""
    listed = [entry for section in entries.values() for entry in section.values()]
    contents = [content for entry in listed for content in (entry.content, *(other for other, _ in entry.instead))]
    return roles.topics | {topic for content in contents for topic in camera_topics(content)}


def _draft_text(document: Mapping[str, Any], entries: Mapping[str, Mapping[str, _Entry]], unread: UnreadTopics) -> str:
    text = yaml.safe_dump({"format": document["format"]})
    if unread.paragraphs:
        text += HOW_TO_UNCOMMENT
    for title, listed in entries.items():
        paragraphs = unread.text(title)
        if listed or paragraphs:
            text += f"{title}:\n" if listed else f"# {title}:\n"
            text += "".join(_written(name, entry) for name, entry in listed.items()) + paragraphs
            text += "\n" if paragraphs else ""
    if unread.text(""):
        text += f"# Nothing to be mapped:\n{unread.text('')}\n"
    if "description" not in document:
        return text + STATE_ALL
    text += yaml.safe_dump({"description": document["description"]}, sort_keys=False, allow_unicode=True)
    return text + STATE_MORE


def _role_entry(role: SignalRole, glimpses: Mapping[str, Glimpse]) -> dict[str, Any]:
    entry: dict[str, Any] = {"topic": role.topic}
    for key in ("frame", "child_frame"):
        if getattr(role, key):
            entry[key] = getattr(role, key)
    for key in ("fields", "units", "joint_names"):
        if getattr(role, key):
            entry[key] = list(getattr(role, key))
    if role.is_rotation_vector:
        entry["rotation"] = "rotation_vector"
    if role.name == "joints" and not (role.joint_names or role.fields):
        entry |= _joint_names(glimpses.get(role.topic))[0]
    return entry


def _candidates(name: str, known: list[Topic], roles: Roles, glimpses: Mapping[str, Glimpse]) -> _Entry | None:
    """The likeliest of the topics that could be a signal and are not read, the others as alternatives."""
    found: list[tuple[dict[str, Any], str]] = []
    parents = {child: parent for glimpse in glimpses.values() for child, parent in glimpse.parents.items()}
    for topic in sorted(known, key=lambda topic: not any(word in topic.name.lower() for word in LIKELY_WORDS[name])):
        if topic.kind not in KINDS_OF_SIGNAL[name] or topic.name in roles.topics:
            continue
        entry: dict[str, Any] = {"topic": topic.name}
        remark = ""
        if topic.kind == TF_KIND:
            frames = _likely_frames(parents)
            if frames is None or is_fixed_tree(topic.name):
                continue
            entry |= {"frame": frames[0], "child_frame": frames[1]}
            remark = "are these the frames of the robot's base and of its tcp?"
        elif name == "joints":
            names, remark = _joint_names(glimpses.get(topic.name))
            entry |= names
        found.append((entry, remark))
    if not found:
        return None
    (entry, remark), *others = found
    if others:
        several = f"{len(found)} topics have the type of a {name}; their names do not say which one is meant: keep one"
        remark = f"{several}. {remark}" if remark else several
    return _Entry(entry, remark, others[:MAX_ALTERNATIVES])


def _joint_names(glimpse: Glimpse | None) -> tuple[dict[str, Any], str]:
    """``joint_names`` from base to wrist as the messages call them, and what a person must check."""
    names = () if glimpse is None else glimpse.joints
    try:
        order = JointOrder((), Counter())(names) if names else None
    except ValueError:
        return {"joint_names": list(names[:6])}, f"several arms: choose six of {', '.join(names)}, base to wrist"
    if order is not None and min(order) >= 0:
        return {"joint_names": [names[place] for place in order]}, ""
    if len(names) < 6:
        return {}, f"its messages name {len(names)} joints, and six are needed"
    return {"joint_names": list(names[:6])}, f"bring these into the order from base to wrist; named: {', '.join(names)}"


def _likely_frames(parents: Mapping[str, str]) -> tuple[str, str] | None:
    """A base frame and a moving frame of one tree, where it has frames with such names."""

    def root(name: str) -> str:
        for _ in parents:
            name = parents.get(name, name)
        return name

    frames = {*parents, *parents.values()}
    for base in (name for name in LIKELY_FRAMES[0] if name in frames):
        for tool in (name for name in LIKELY_FRAMES[1] if name in parents):
            if root(base) == root(tool):
                return base, tool
    return None


def _images(
    known: Sequence[Topic],
    roles: Roles,
    serials: Mapping[str, Sequence[str]],
    description: LogDescription,
    glimpses: Mapping[str, Glimpse],
    one_camera: Sequence[str],
    of_cameras: Mapping[str, Sequence[str]],
) -> tuple[dict[str, _Entry], dict[str, Any]]:
    """Cameras, and the sensors that the recording does not describe."""
    cameras: list[tuple[str, dict[str, Any], str]] = [
        (
            _by_model(role.camera, serials.get(role.topic, ()), description),
            _source(role.topic, path_of(role.data)),
            NOT_SAID if role.camera == ONLY_CAMERA else "",
        )
        for role in roles.images
    ]
    if not cameras:
        sources = [_source(topic.name) for topic in known if topic.kind in IMAGE_KINDS] or [
            _source(topic.name, path) for topic in known for path in picture_fields(glimpses.get(topic.name, Glimpse()))
        ]
        cameras = [("digit" if n == 0 else f"digit_{n + 1}", source, NOT_SAID) for n, source in enumerate(sources)]
    cameras = [
        (camera, {**source, "topic": list(of_cameras[camera])} if camera in of_cameras else source, remark)
        for camera, source, remark in cameras
    ]
    if one_camera:
        camera, source, remark = cameras[0]
        cameras = [(camera, {**source, "topic": list(one_camera)}, remark)]
    entries: dict[str, _Entry] = {}
    sensors: dict[str, Any] = {}
    for camera, source, remark in cameras:
        model = "gelsight_r15" if camera.startswith("gelsight") else "digit"
        stated = [serials.get(topic, ()) for topic in camera_topics(source)]
        named = list(dict.fromkeys(serial for of_topic in stated for serial in of_topic))
        if len(named) > 1 or (named and not all(stated)):
            own = f"its sensor is left open, as each recording names its own: {', '.join(named)}"
            entries[camera] = _Entry(source, "; ".join(filter(None, (remark, own))))
            sensors |= {serial: {"model": model} for serial in named if serial not in description.sensors}
            continue
        serial = "".join(named)
        if not serial and description.sensors:
            remark = "; ".join(
                filter(None, (remark, f"which sensor is it? sensor: {' or '.join(description.sensors)}"))
            )
            entries[camera] = _Entry(source, remark)
            continue
        if not serial:
            serial = f"{PLACEHOLDER}-with-serial-of-{camera}"
        entries[camera] = _Entry({**source, "sensor": serial}, remark)
        if serial not in description.sensors:
            sensors[serial] = {"model": model}
    return entries, sensors


def _by_model(camera: str, serials: Sequence[str], description: LogDescription) -> str:
    """The name that cameras of a sensor's model have in other recordings, for one whose topic says no name.

    A model that the recording does not state is drafted as that of a DIGIT, and so is the name.
    """
    if camera != ONLY_CAMERA:
        return camera
    stated = [description.sensors[serial].get("model", "") for serial in serials if serial in description.sensors]
    model = next(filter(None, stated), "digit")
    return next((word for word in TACTILE_WORDS if model.startswith(word)), camera)


def _source(topic: str, data: str = "") -> dict[str, Any]:
    """Return where pictures are: their topic, and the field in messages whose type does not say it."""
    return {"topic": topic, "data": data} if data else {"topic": topic}


def _written(name: str, entry: _Entry) -> str:
    text = _indented(entry_text({name: entry.content}), "  ")
    if entry.remark:
        text = f"  # {on_one_line(entry.remark)}\n" + text
    for content, remark in entry.instead:
        other = entry_text({name: content})
        text += _indented((f"# {on_one_line(remark)}\n" if remark else "") + other, "  # ")
    return text


def _indented(text: str, by: str) -> str:
    return "".join(f"{by}{line}\n" for line in text.splitlines())
