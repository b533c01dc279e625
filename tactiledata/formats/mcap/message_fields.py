"""Fields of decoded messages, by paths: those that the message's type has, and never attributes of Python objects."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

MOST_NAMED = 12
"""Fields that an error lists."""
MOST_SHOWN = 40
"""Characters of a text that an error shows."""


def steps_of(path: str) -> tuple[str | int, ...]:
    """``pose.position.x``, ``effort[2]``, or ``[2]`` of a message that is a list, as the steps that lead to the value.

    Raises
    ------
    ValueError
        No path of fields.
    """
    steps: list[str | int] = []
    for position, part in enumerate(path.split(".")):
        match = re.fullmatch(r"([A-Za-z_]\w*)?((?:\[\d+\])*)", part)
        if match is None or not (match[1] or (match[2] and position == 0)):
            raise ValueError(f"{path!r} is no path of fields")
        steps += [match[1]] if match[1] else []
        steps += [int(index) for index in re.findall(r"\d+", match[2])]
    return tuple(steps)


class NoSuchField(AttributeError):
    """Raised for a path that leaves the fields of a message: an attribute of the object that holds it, an item that an
    array is too short for, or a mistake.

    Parameters
    ----------
    steps : tuple
        The path.
    count : int
        How many of its steps are fields.
    value : object
        What stands where the next step would begin.
    """

    def __init__(self, steps: tuple[str | int, ...], count: int, value: Any) -> None:
        step, place = steps[count], path_of(steps[:count])
        wanted = f"item [{step}]" if isinstance(step, int) else f"field {step!r}"
        super().__init__(f"{repr(place) if place else 'the message'} has no {wanted}")
        self.steps, self.expected = steps, _alternative(place, value)


def path_of(steps: tuple[str | int, ...]) -> str:
    """The path that `steps_of` takes apart."""
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps).removeprefix(".")


def _alternative(place: str, value: Any) -> str:
    """What a path could name instead where it left the fields of a message, for people."""
    whole = repr(place) if place else "the message"
    names = field_names(value)
    if names is not None:
        listed = ", ".join(names[:MOST_NAMED]) + (", …" if len(names) > MOST_NAMED else "")
        return f"a field of {whole}: {listed}" if names else f"another field: {whole} has none"
    if isinstance(value, str | bytes):
        return f"another field: {whole} is {'a text' if isinstance(value, str) else 'bytes'}"
    if hasattr(value, "__len__"):
        return f"an item of {whole}: {_items(place, len(value))}" if len(value) else f"another field: {whole} is empty"
    return f"{whole} itself, which is a number" if isinstance(value, int | float | np.number) else "another field"


def _items(place: str, count: int) -> str:
    """Paths of the items of an array, the first and the last."""
    return f"{place}[0]" if count == 1 else f"{place}[0] to {place}[{count - 1}]"


def kind_in_words(value: Any) -> str:
    """What stands in a field that holds no number, in words.

    Examples
    --------
    >>> kind_in_words(None), kind_in_words("3 N"), kind_in_words([1, 2])
    ('null', "the text '3 N'", 'an array')
    """
    if value is None:
        return "null"
    if isinstance(value, str):
        return f"the text {value[:MOST_SHOWN]!r}" + (" …" if len(value) > MOST_SHOWN else "")
    if field_names(value) is not None:
        return "a group of fields"
    return "an array" if hasattr(value, "__len__") else f"of the type {type(value).__name__}"


def field_names(value: Any) -> tuple[str, ...] | None:
    """The fields of a dictionary, a ROS message or a protobuf message, by name; ``None`` of anything else."""
    if isinstance(value, Mapping):
        return tuple(str(name) for name in value)
    if hasattr(value, "DESCRIPTOR"):
        return tuple(field.name for field in value.DESCRIPTOR.fields)
    if hasattr(value, "__dataclass_fields__"):
        return tuple(name for name in value.__dataclass_fields__ if name[0] != "_")
    return None


def value_at(message: Any, steps: tuple[str | int, ...]) -> Any:
    """The value that a path leads to, in a dictionary, a ROS message or a protobuf message.

    Raises
    ------
    NoSuchField
        A step that is no field of a message and no item of an array: no attribute of the objects is ever read.
    ValueError
        An item of an array that is empty.
    """
    value = message
    for count, step in enumerate(steps):
        if not _has(value, step):
            if isinstance(step, int) and _is_array(value) and not len(value):
                raise ValueError(f"{path_of(steps[:count]) or 'the message'!r} is empty")
            raise NoSuchField(steps, count, value)
        value = value[step] if isinstance(step, int) or isinstance(value, Mapping) else getattr(value, step)
    return value


def _has(value: Any, step: str | int) -> bool:
    """Whether a step leads to a field, or to an item of an array."""
    if isinstance(value, Mapping):
        return step in value
    if isinstance(step, int):
        return _is_array(value) and step < len(value)
    if hasattr(value, "DESCRIPTOR"):
        return step in value.DESCRIPTOR.fields_by_name
    return step[0] != "_" and step in getattr(value, "__dataclass_fields__", ())


def _is_array(value: Any) -> bool:
    return hasattr(value, "__len__") and not isinstance(value, str | Mapping)


def stamp_of(message: Any) -> int | None:
    """The stamp that a message carries, ns; ``None`` where its type has none."""
    for steps in (("header", "stamp"), ("timestamp",), ("stamp",)):
        try:
            stamp = value_at(message, steps)
            return _first(stamp, "sec", "seconds") * 1_000_000_000 + _first(stamp, "nanosec", "nsec", "nanos")
        except (AttributeError, KeyError, TypeError):
            continue
    return None


def _first(stamp: Any, *names: str) -> int:
    for name in names:
        found = stamp.get(name) if isinstance(stamp, Mapping) else getattr(stamp, name, None)
        if found is not None:
            return int(found)
    raise KeyError(names[0])


def frame_of(message: Any) -> str:
    """The frame_id that a message carries; empty where it has none."""
    for steps in (("header", "frame_id"), ("frame_id",)):
        try:
            return str(value_at(message, steps))
        except (AttributeError, KeyError, TypeError):
            continue
    return ""
