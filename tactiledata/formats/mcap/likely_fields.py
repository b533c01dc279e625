"""Which numbers of an unknown message could be a wrench, a pose or joints: a proposal for a person, never a guess."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from tactiledata.formats.mcap.contents import Place
from tactiledata.units import SIGNAL_COLUMNS

WORDS = {
    "wrench": ("wrench", "force", "torque", "ft", "robotiq"),
    "tcp": ("tcp", "pose", "tool", "flange"),
    "joints": ("joint", "actual_q"),
}
"""Words in the name of a topic or field that speak for a signal."""
AXES = {3: "xyz", 4: "xyzw"}
TIMES = re.compile(r"(time|timestamp|stamp|t|seq|sec|nanosec)(\.|$)", re.IGNORECASE)
DESCRIBING = re.compile(r"(header|layout)\.")
"""The head of a message, and what a std_msgs array says of its own shape."""


def _names(stems: Sequence[str], axes: str) -> tuple[tuple[str, ...], ...]:
    return tuple(tuple(f"{stem}{axis}" for stem in stems) for axis in axes)


CALLED = {
    "wrench": (*_names(("force", "f"), "xyz"), *_names(("torque", "moment", "t", "m"), "xyz")),
    "tcp": (
        *_names(("position", "translation", "pos", "p", ""), "xyz"),
        *_names(("orientation", "rotation", "quaternion", "quat", "rot", "q"), "xyzw"),
    ),
}
"""How drivers call the numbers of a signal, column by column: the last name of a path, or the last two. The first of a
column's names that occurs is taken."""


@dataclass(frozen=True)
class FieldGuess:
    """Fields that could be a signal, and why; ``is_named`` where the fields' own names say so.

    With ``is_rotation_vector`` they are six of a tcp, the last three a rotation vector.
    """

    signal: str
    fields: tuple[str, ...]
    reason: str
    is_named: bool = False
    is_rotation_vector: bool = False


def proposal_for(topic: str, places: Sequence[Place]) -> FieldGuess | None:
    """The signal that a message's numbers could be; ``None`` where nothing speaks for one."""
    numbers = measured(places)
    for signal in CALLED:
        fields = _called(signal, numbers)
        if fields:
            return FieldGuess(signal, fields, f"the names of its fields are those of a {signal}", True)
    for place in numbers:
        found = _counted(f"{topic} {place.path}".lower(), place.fields) if place.is_array else None
        if found is not None:
            return found
    return None


def measured(places: Sequence[Place]) -> list[Place]:
    """The places with numbers that are no times, counters or descriptions of an array."""
    return [
        place
        for place in places
        if place.fields and not (DESCRIBING.match(place.path) or (TIMES.match(place.path) and not place.is_array))
    ]


def speaks_for(signal: str, text: str) -> bool:
    """Whether a topic's or field's name has a word that speaks for a signal."""
    parts = set(re.split(r"[^a-z0-9]+", text.lower()))
    return any(word in parts or (len(word) > 2 and word in text.lower()) for word in WORDS[signal])


def _called(signal: str, numbers: Sequence[Place]) -> tuple[str, ...]:
    """Fields in the order of the signal's columns, where each column has exactly one."""
    named: list[tuple[str, str]] = []
    for place in numbers:
        if place.is_array and len(place.fields) in AXES:
            named += [(f"{place.path}.{a}", f) for a, f in zip(AXES[len(place.fields)], place.fields, strict=True)]
        elif not place.is_array:
            named.append((place.path, place.path))
    fields = []
    for names in CALLED[signal]:
        fitting = [[field for path, field in named if name in _endings(path)] for name in names]
        first = next((fits for fits in fitting if fits), [])
        if len(first) != 1:
            return ()
        fields.append(first[0])
    return tuple(fields)


def _endings(path: str) -> set[str]:
    """The last name of a path, and the last two together, without case and underscores."""
    parts = [part.lower().replace("_", "") for part in path.split(".")]
    return {parts[-1], "".join(parts[-2:])}


def _counted(text: str, fields: tuple[str, ...]) -> FieldGuess | None:
    """What an array of six or seven numbers could be."""
    if len(fields) == 7 and not speaks_for("joints", text):
        return FieldGuess("tcp", fields, "seven numbers, as a position and a quaternion have (x, y, z, qx, qy, qz, qw)")
    if len(fields) != 6:
        return None
    if speaks_for("joints", text):
        return FieldGuess("joints", fields, "six numbers, as six joints have (base to wrist)")
    if speaks_for("tcp", text) and not speaks_for("wrench", text):
        reason = "six numbers, as a position and a rotation vector have (x, y, z, rx, ry, rz; other angles are no tcp)"
        return FieldGuess("tcp", fields, reason, is_rotation_vector=True)
    columns = ", ".join(SIGNAL_COLUMNS["wrench"])
    return FieldGuess(
        "wrench", fields, f"six numbers, as a wrench has ({columns}); six joints would be called joints, in rad"
    )
