"""One mapping for several recordings: what all of them hold together, and which topics only some of them have."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tactiledata.contract.description import LogDescription
from tactiledata.contract.wording import counted, listed
from tactiledata.formats.mcap.images import stated_serials
from tactiledata.formats.mcap.mapping_draft import Draft, draft_mapping
from tactiledata.formats.mcap.roles import IMAGE_KINDS, ImageRole, Roles, Topic, roles_of
from tactiledata.formats.mcap.unread_topics import Glimpse, on_one_line
from tactiledata.formats.reading.described import camera_topics
from tactiledata.formats.reading.natural_order import natural_key

MOST_NAMED = 5
"""Recordings that a comment names; of more, how many they are is said too."""


@dataclass(frozen=True)
class DraftGrounds:
    """What one recording gives to a draft of a mapping.

    Parameters
    ----------
    key : str
        Name of the recording.
    topics : sequence of Topic
    roles : Roles
        What is read of it now.
    glimpses : dict, topic -> Glimpse
    description : LogDescription
        What it says of itself.
    """

    key: str
    topics: Sequence[Topic]
    roles: Roles
    glimpses: Mapping[str, Glimpse]
    description: LogDescription

    @property
    def serials(self) -> dict[str, str]:
        """Serials of sensors that its image topics say, by topic."""
        pictures = (topic.name for topic in self.topics if topic.kind in IMAGE_KINDS)
        cameras = self.roles.images or tuple(ImageRole("", name) for name in pictures)
        found = {}
        for role in cameras:
            frame = self.glimpses[role.topic].frame if role.topic in self.glimpses else ""
            stated = stated_serials(role, tuple(self.description.sensors), len(cameras) == 1, frame)
            found[role.topic] = next(iter(stated.values()), "")
        return found


def joint_draft(grounds: Sequence[DraftGrounds], mapping: Mapping[str, Any] | None = None) -> Draft:
    """Draft one mapping that reads the topics of all recordings; above it stands which of them lack a topic.

    Parameters
    ----------
    grounds : sequence of DraftGrounds
        At least one.
    mapping : dict, optional
        The mapping by which the recordings were looked at.
    """
    topics = _all_topics(grounds)
    of_cameras = _listed(topics, mapping or {})
    # of a camera's topics each recording has one, and the roles name the first of them
    others = {topic for of_camera in of_cameras.values() for topic in of_camera[1:]}
    firsts = [topic for topic in topics if topic.name not in others]
    roles = grounds[0].roles if len(grounds) == 1 else roles_of(firsts, mapping)
    serials: dict[str, list[str]] = {}
    sensors: dict[str, Any] = {}
    for part in grounds:
        sensors = {**part.description.sensors, **sensors}
        for topic, serial in part.serials.items():
            if serial and serial not in serials.setdefault(topic, []):
                serials[topic].append(serial)
    described = LogDescription({"sensors": sensors}) if sensors else LogDescription()
    one_camera = () if "images" in (mapping or {}) else _one_camera(grounds)
    draft = draft_mapping(topics, roles, _all_glimpses(grounds), serials, described, one_camera, of_cameras)
    if len(grounds) == 1:
        return draft
    return dataclasses.replace(draft, text="".join(f"# {on_one_line(line)}\n" for line in _head(grounds)) + draft.text)


def _listed(topics: Sequence[Topic], mapping: Mapping[str, Any]) -> dict[str, list[str]]:
    """Topics of each camera of a mapping that lists several of those that the recordings have, by camera."""
    names = sorted((topic.name for topic in topics), key=natural_key)
    found: dict[str, list[str]] = {}
    for camera, entry in mapping.get("images", {}).items():
        wanted = {name.strip("/") for name in camera_topics(entry)}
        found[camera] = [name for name in names if name.strip("/") in wanted]
    return {camera: several for camera, several in found.items() if len(several) > 1}


def _one_camera(grounds: Sequence[DraftGrounds]) -> list[str]:
    """Several topics of one type, of which each recording has one and no other camera; else none."""
    topics: list[str] = []
    kinds = set()
    for part in grounds:
        pictures = {topic.name: topic.kind for topic in part.topics if topic.kind in IMAGE_KINDS}
        cameras = [(role.camera, role.topic) for role in part.roles.images] or [("", topic) for topic in pictures]
        if len(cameras) > 1:
            return []
        for camera, topic in cameras:
            topics.append(topic)
            kinds.add((camera, pictures.get(topic, "")))
    several = sorted(set(topics), key=natural_key)
    return several if len(several) > 1 and len(kinds) == 1 else []


def _all_topics(grounds: Sequence[DraftGrounds]) -> list[Topic]:
    """Every topic of the recordings, once; one that can be read stands before one that cannot."""
    found: dict[str, Topic] = {}
    for topic in (topic for part in grounds for topic in part.topics):
        if topic.name not in found or (topic.is_readable and not found[topic.name].is_readable):
            found[topic.name] = topic
    return list(found.values())


def _all_glimpses(grounds: Sequence[DraftGrounds]) -> dict[str, Glimpse]:
    """What the recordings say of each topic: the first that says it, and the messages of all of them."""
    found: dict[str, Glimpse] = {}
    for name, new in (item for part in grounds for item in part.glimpses.items()):
        old = found.get(name)
        found[name] = new if old is None else Glimpse(
            old.frame or new.frame,
            old.joints or new.joints,
            {**new.parents, **old.parents},
            old.encoding or new.encoding,
            old.note or new.note,
            old.messages + new.messages,
            new.rate if old.rate is None else old.rate,
            new.contents if old.contents is None else old.contents,
        )  # fmt: skip
    return found


def _head(grounds: Sequence[DraftGrounds]) -> Iterator[str]:
    """Yield remarks on the recordings that a draft is made from, and on what sets them apart."""
    yield f"Drafted from {counted(len(grounds), 'recording')}: {_named([part.key for part in grounds])}."
    kinds: dict[str, dict[str, list[str]]] = {}
    for part in grounds:
        for topic in part.topics:
            kinds.setdefault(topic.name, {}).setdefault(topic.kind or "no type", []).append(part.key)
    holders = {name: [key for keys in by_kind.values() for key in keys] for name, by_kind in kinds.items()}
    rare = sorted((name for name, keys in holders.items() if len(keys) < len(grounds)), key=natural_key)
    yield "Topics that only some of them have:" if rare else "All of them have the same topics."
    for name in rare:
        yield f"  {name}: {len(holders[name])} of {len(grounds)}: {_named(holders[name])}"
    if rare:
        yield "Ingest says what each recording lacks of this mapping; one that differs much needs a mapping of its own."
    mixed = sorted((name for name, by_kind in kinds.items() if len(by_kind) > 1), key=natural_key)
    if mixed:
        yield "Topics whose type is not the same in all of them (one mapping may not read them all):"
    for name in mixed:
        yield f"  {name}: {'; '.join(f'{kind} in {_named(keys)}' for kind, keys in kinds[name].items())}"


def _named(keys: Sequence[str]) -> str:
    """Return the first few names of recordings."""
    return listed(keys, MOST_NAMED)
