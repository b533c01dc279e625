"""Topics that a draft of a mapping does not read: what each holds, and the lines that would read it, in comments."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import yaml

from tactiledata.contract.description import PLACEHOLDER
from tactiledata.contract.wording import counted
from tactiledata.formats.mcap.contents import Contents, Place
from tactiledata.formats.mcap.likely_fields import FieldGuess, measured, proposal_for, speaks_for
from tactiledata.formats.mcap.roles import (
    COLUMNS_OF,
    IMAGE_KINDS,
    TF_KIND,
    Topic,
    is_fixed_tree,
)
from tactiledata.units import signal_units

MAX_FIELDS = 16
MAX_SHOWN = 16
HOW_TO_UNCOMMENT = """\
# Topics that are not read stand in paragraphs of comments. To read one, remove the first "# " of each line of its
# paragraph (and of `signals:` or `images:` above it, where that is commented out), then check its name and units.
# Where a "?" stands, write the unit.
"""


@dataclass(frozen=True)
class Glimpse:
    """What the first messages of a topic say that a mapping needs.

    Parameters
    ----------
    frame : str
        ``frame_id`` of its first message.
    joints : tuple of str
        Names in its first message with joints.
    parents : dict, child frame -> frame
        Edges of a tree of transforms.
    encoding, note : str
        How its messages are encoded, and why they cannot be decoded.
    messages : int
    rate : float, optional
        Hz.
    contents : Contents, optional
        Of its first message that could be decoded.
    """

    frame: str = ""
    joints: tuple[str, ...] = ()
    parents: Mapping[str, str] = field(default_factory=dict)
    encoding: str = ""
    note: str = ""
    messages: int = 0
    rate: float | None = None
    contents: Contents | None = None


@dataclass
class UnreadTopics:
    """Paragraphs of comments, by the section of a mapping that they belong to; ``""``: nothing to be mapped."""

    paragraphs: dict[str, list[str]] = field(default_factory=dict)

    def text(self, section: str) -> str:
        """The paragraphs of a section, each after an empty line."""
        return "".join(f"\n{paragraph}" for paragraph in self.paragraphs.get(section, ()))


def unread_topics(
    topics: Iterable[Topic], glimpses: Mapping[str, Glimpse], taken: Mapping[str, Collection[str]]
) -> UnreadTopics:
    """A paragraph for each topic.

    Parameters
    ----------
    topics : iterable of Topic
        Those that the draft does not name.
    glimpses : dict, topic -> Glimpse
    taken : dict, section -> names
        Signals and images that the draft has; a proposal never takes a name twice.
    """
    result = UnreadTopics()
    names = {section: set(taken.get(section, ())) for section in ("signals", "images")}
    listed = list(topics)
    chosen = _chosen(listed, glimpses, names["signals"])
    names["signals"] |= set(chosen)
    for topic in listed:
        glimpse = glimpses.get(topic.name, Glimpse())
        proposal = _proposal(topic, glimpse)
        section, remarks, entry = "", _holds(topic, glimpse), {}
        if topic.kind in IMAGE_KINDS and topic.is_readable:
            section, name = "images", _free_name(topic.name, names["images"], "camera")
            remarks.append("pictures: give the sensor's serial, and describe that under description: sensors:")
            entry = {name: {"topic": topic.name, "sensor": f"{PLACEHOLDER}-with-serial-of-{name}"}}
        elif topic.kind == TF_KIND:
            section, entry = _tree(topic, chosen, remarks)
        elif topic.is_readable and (pictures := picture_fields(glimpse)):
            section = "images"
            remarks.append("pictures: give each sensor's serial, and describe it under description: sensors:")
            for path in pictures:
                name = _free_name(topic.name, names["images"], "camera")
                serial = f"{PLACEHOLDER}-with-serial-of-{name}"
                entry[name] = {"topic": topic.name, "data": path, "sensor": serial}
        elif topic.is_readable and glimpse.contents is not None:
            own = next((name for name, winner in chosen.items() if winner == topic.name), "")
            entry = _numbers(topic, glimpse.contents, proposal, own, names["signals"], remarks)
            section = "signals" if entry else ""
        result.paragraphs.setdefault(section, []).append(_paragraph(remarks, entry))
    return result


def _chosen(topics: Sequence[Topic], glimpses: Mapping[str, Glimpse], taken: Collection[str]) -> dict[str, str]:
    """Signal that no topic is read as -> the likeliest of the topics that could be it."""
    rivals: dict[str, list[tuple[bool, bool, int, str]]] = {}
    for place, topic in enumerate(topics):
        proposal = _proposal(topic, glimpses.get(topic.name, Glimpse()))
        if topic.kind == TF_KIND and not is_fixed_tree(topic.name):
            rivals.setdefault("tcp", []).append((True, True, len(topics) + place, topic.name))
        elif proposal is not None:
            text = " ".join((topic.name, *proposal.fields))
            order = (not speaks_for(proposal.signal, text), not proposal.is_named, place, topic.name)
            rivals.setdefault(proposal.signal, []).append(order)
    return {signal: min(listed)[-1] for signal, listed in rivals.items() if signal not in taken}


def _proposal(topic: Topic, glimpse: Glimpse) -> FieldGuess | None:
    if not topic.is_readable or topic.kind in (TF_KIND, *IMAGE_KINDS) or glimpse.contents is None or glimpse.joints:
        return None
    if picture_fields(glimpse):
        return None
    return proposal_for(topic.name, glimpse.contents.places)


def picture_fields(glimpse: Glimpse) -> tuple[str, ...]:
    """Paths of the fields that hold an encoded picture and that a mapping can name."""
    places = () if glimpse.contents is None else glimpse.contents.places
    return tuple(place.path for place in places if place.is_picture and place.path)


def _holds(topic: Topic, glimpse: Glimpse) -> list[str]:
    """What a topic holds: its type, number, rate and time, then its fields with an example."""
    rate = "no rate" if glimpse.rate is None else f"{glimpse.rate:.1f} Hz"
    facts = f"{topic.kind or 'no type'} ({glimpse.encoding or '?'}), {counted(glimpse.messages, 'message')}, {rate}"
    lines = [f"{topic.name}: {facts}"]
    if glimpse.note:
        lines.append(f"cannot be read: {glimpse.note}")
    if glimpse.contents is None:
        return lines if glimpse.note else [*lines, "it holds no message that says what it is"]
    lines[0] += ", its own stamp" if glimpse.contents.has_stamp else ", no stamp of its own: its time is its log time"
    lines[0] += f", frame_id {glimpse.contents.frame!r}" if glimpse.contents.frame else ", no frame_id"
    if topic.kind == TF_KIND:
        edges = [f"{parent} -> {child}" for child, parent in sorted(glimpse.parents.items())]
        return [*lines, "transforms: " + ", ".join(edges[:MAX_SHOWN]) + (", …" if edges[MAX_SHOWN:] else "")]
    places = glimpse.contents.places
    for place in places[:MAX_SHOWN]:
        example = f", for example {place.example}" if place.example else ""
        lines.append(f"{place.path or 'the message itself'}: {place.what}{example}")
    return [*lines, f"and {len(places) - MAX_SHOWN} more fields"] if len(places) > MAX_SHOWN else lines


def _tree(topic: Topic, chosen: Mapping[str, str], remarks: list[str]) -> tuple[str, dict[str, Any]]:
    """How to read a pose from a tree of transforms."""
    if is_fixed_tree(topic.name):
        remarks.append("fixed transforms: they are used where tcp is read from the tree that they belong to")
        return "", {}
    frames = {"frame": f"{PLACEHOLDER}-with-base", "child_frame": f"{PLACEHOLDER}-with-tool"}
    if chosen.get("tcp") != topic.name:
        remarks.append(
            "a tree of transforms: for a pose from it, give the signal tcp this topic, frame and child_frame"
        )
        return "", {}
    remarks.append("a tree of transforms: name the frames of the robot's base and of its tcp")
    return "signals", {"tcp": {"topic": topic.name, **frames}}


def _numbers(
    topic: Topic, contents: Contents, proposal: FieldGuess | None, own: str, taken: set[str], remarks: list[str]
) -> dict[str, Any]:
    """The entry that reads a topic's numbers: as the signal that it could be, else all of them under its own name."""
    fields = proposal.fields if proposal else _all_fields(contents.places)
    if not fields:
        remarks.append("it holds no numbers that a mapping can read")
        return {}
    if proposal:
        remarks.append(f"{proposal.reason}: check the order and the units")
    name = own or _free_name(topic.name, taken, "signal")
    if proposal and not own:
        remarks.append(f"if this is the {proposal.signal}, call it {proposal.signal}, and only this one")
        if proposal.is_rotation_vector:
            remarks.append("beside topic then stands `rotation: rotation_vector`")
    if len(fields) > MAX_FIELDS:
        remarks.append(f"the first {MAX_FIELDS} of {len(fields):,} numbers; name the ones that you need")
        fields = fields[:MAX_FIELDS]
    if proposal and proposal.signal != "joints" and not contents.frame:
        remarks.append("it states no frame: `frame: NAME` beside topic says which one its numbers are in")
    entry: dict[str, Any] = {"topic": topic.name, "fields": list(fields), "units": _units(proposal, fields)}
    if proposal and proposal.is_rotation_vector and name == "tcp":
        entry["rotation"] = "rotation_vector"
    return {name: entry}


def _units(proposal: FieldGuess | None, fields: Sequence[str]) -> list[str]:
    return list(signal_units(tuple(fields)) if proposal is None else proposal.units)


def _all_fields(places: Sequence[Place]) -> tuple[str, ...]:
    return tuple(path for place in measured(places) for path in place.fields)


def _free_name(topic: str, taken: set[str], otherwise: str) -> str:
    """A name made of a topic's that is not taken; it is then."""
    plain = re.sub(r"[^a-z0-9]+", "_", topic.lower()).strip("_")[:56].strip("_")
    plain = plain if plain[:1].isalpha() and plain.isascii() else f"{otherwise}_{plain}".strip("_")
    plain = f"{plain}_numbers" if plain in COLUMNS_OF else plain
    name, count = plain, 1
    while name in taken:
        count += 1
        name = f"{plain}_{count}"
    taken.add(name)
    return name


def _paragraph(remarks: Sequence[str], entry: Mapping[str, Any]) -> str:
    """Remarks and an entry, all in comments; where the first "# " of a line goes, an entry is YAML, a remark is not."""
    text = "".join(f"# {on_one_line(remark)}\n" for remark in remarks)
    text += entry_text(entry, default_flow_style=None) if entry else ""
    return "".join(f"  # {line}\n" for line in text.splitlines())


class _OneLineTexts(yaml.SafeDumper):
    """YAML whose texts never break a line, so that each line can stand in a comment."""


_OneLineTexts.add_representer(
    str,
    lambda dumper, text: dumper.represent_scalar(
        "tag:yaml.org,2002:str", text, style=None if text.isprintable() else '"'
    ),
)


def entry_text(entry: Mapping[str, Any], default_flow_style: bool | None = False) -> str:
    """An entry of a mapping as YAML, in block style (``False``) or with its lists on one line (``None``)."""
    return yaml.dump(
        dict(entry),
        Dumper=_OneLineTexts,
        sort_keys=False,
        allow_unicode=True,
        width=10**6,
        default_flow_style=default_flow_style,
    )


def on_one_line(text: str) -> str:
    """A text without what would end a comment: line breaks of any kind, and characters that YAML refuses."""
    return "".join(letter if letter.isprintable() else " " for letter in text)
