"""Which numbers of an unknown message could be a wrench, a pose or joints: a proposal for a person, never a guess."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from tactiledata.formats.mcap.contents import Place
from tactiledata.formats.mcap.roles import ROTATION_VECTOR_UNITS
from tactiledata.units import SIGNAL_COLUMNS, signal_units

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
ROTATION_VECTOR = (*CALLED["tcp"][:3], *_names(("r", "rv", "rotvec", "rotationvector", "rot", "rotation"), "xyz"))
"""How drivers call the six numbers of a pose whose rotation is a vector, as UR controllers give it: see ``CALLED``."""
UNITS = {
    **{"m": "m", "mm": "mm", "rad": "rad", "deg": "deg", "n": "N", "mn": "mN", "kn": "kN"},
    **{"nm": "N m", "nmm": "N mm", "newton": "N", "newtons": "N"},
}
"""Unit that stands behind the name of a field (``x_mm``) -> as a mapping calls it."""
FARTHEST_M = 10.0
"""Larger numbers are no position of an arm in metres."""


@dataclass(frozen=True)
class FieldGuess:
    """Fields that could be a signal, and why; ``is_named`` where the fields' own names say so.

    With ``is_rotation_vector`` they are six of a tcp, the last three a rotation vector. ``units`` are those that names
    or sizes speak for, else the signal's own.
    """

    signal: str
    fields: tuple[str, ...]
    reason: str
    is_named: bool = False
    is_rotation_vector: bool = False
    units: tuple[str, ...] = ()


def proposal_for(topic: str, places: Sequence[Place]) -> FieldGuess | None:
    """The signal that a message's numbers could be; ``None`` where nothing speaks for one."""
    numbers = measured(places)
    for signal, names in (*CALLED.items(), ("tcp", ROTATION_VECTOR)):
        fields = _called(names, numbers)
        if fields:
            reason = f"the names of its fields are those of a {signal}"
            is_vector = names is ROTATION_VECTOR
            reason += " with a rotation vector (other angles are no tcp)" if is_vector else ""
            return _with_units(FieldGuess(signal, fields, reason, True, is_vector), numbers)
    for place in numbers:
        found = _counted(f"{topic} {place.path}".lower(), place.fields) if place.is_array else None
        if found is not None:
            return _with_units(found, numbers)
    return None


def _with_units(guess: FieldGuess, numbers: Sequence[Place]) -> FieldGuess:
    """The guess with units: those that names of its fields or the size of its positions speak for, else the usual."""
    usual = ROTATION_VECTOR_UNITS if guess.is_rotation_vector else signal_units(SIGNAL_COLUMNS[guess.signal])
    if guess.signal == "joints":
        return replace(guess, units=usual)
    named = [UNITS.get(_unit_behind(path), "") for path in guess.fields]
    if any(named):
        return replace(guess, units=tuple(own or unit for own, unit in zip(named, usual, strict=True)))
    first = {path: value for place in numbers for path, value in zip(place.fields, place.values, strict=False)}
    is_far = any(abs(first.get(path, 0.0)) > FARTHEST_M for path in guess.fields[:3])
    if guess.signal == "tcp" and is_far:
        reason = f"{guess.reason}; positions beyond {FARTHEST_M:g} are taken for millimetres"
        return replace(guess, units=("mm", "mm", "mm", *usual[3:]), reason=reason)
    return replace(guess, units=usual)


def _unit_behind(path: str) -> str:
    """What stands behind the last underscore of a field's name, in small letters; empty where none does."""
    name = path.rpartition(".")[2].partition("[")[0].lower()
    return name.rpartition("_")[2] if "_" in name else ""


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


def _called(columns: Sequence[tuple[str, ...]], numbers: Sequence[Place]) -> tuple[str, ...]:
    """Fields in the order of columns that may be called so, where each column has exactly one."""
    named: list[tuple[str, str]] = []
    for place in numbers:
        if place.is_array and len(place.fields) in AXES:
            named += [(f"{place.path}.{a}", f) for a, f in zip(AXES[len(place.fields)], place.fields, strict=True)]
        elif not place.is_array:
            named.append((place.path, place.path))
    fields = []
    for names in columns:
        fitting = [[field for path, field in named if name in _endings(path)] for name in names]
        first = next((fits for fits in fitting if fits), [])
        if len(first) != 1:
            return ()
        fields.append(first[0])
    return tuple(fields)


def _endings(path: str) -> set[str]:
    """The last name of a path, and the last two together, without case, underscores and the units behind them."""
    plain = [part[: -len(unit) - 1] if (unit := _unit_behind(part)) in UNITS else part for part in path.split(".")]
    parts = [part.lower().replace("_", "") for part in plain]
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
