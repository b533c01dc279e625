"""What a decoded message holds, by the paths under which a mapping can name it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactiledata.formats.mcap.message_fields import frame_of, stamp_of

MAX_DEPTH = 8
MAX_ITEMS = 8
"""Entries of a list of messages that are looked into."""
MAX_PLACES = 64
MAX_EXAMPLE = 8
FEWEST_BYTES = 64
"""An array of so many 8-bit numbers is taken for bytes, such as pixels."""
PICTURES = {b"\xff\xd8\xff": "JPEG", b"\x89PNG\r\n\x1a\n": "PNG"}
"""First bytes of an encoded picture -> its format."""
PICTURE_TEXTS = re.compile(r"(?:data:[^,]{0,200};base64,)?(?P<head>/9j/|iVBORw0KGgo)[A-Za-z0-9+/=\s]{32}")
"""How the same bytes begin as base64 text."""
HEAD = 16
"""Bytes that are looked at to know a picture."""
NAME = re.compile(r"[A-Za-z_]\w*")
STAMPS = re.compile(r"(header|timestamp|stamp|frame_id)(\.|$)")


@dataclass(frozen=True)
class Place:
    """A place in a message: a number, an array of numbers, or something that is no number.

    Parameters
    ----------
    path : str
        As `fields` in a mapping name it; of an array without the index.
    what : str
        For people: ``"number"``, ``"6 numbers (float64)"``, ``"text"``.
    fields : tuple of str
        Paths of its numbers; empty where it holds none that a mapping can read.
    example : str
    values : tuple of float
        Its first numbers, in the order of ``fields``; those of ``example``.
    is_array : bool
    is_picture : bool
        Whether it begins as a JPEG or PNG does, as bytes or as base64 text.
    """

    path: str
    what: str
    fields: tuple[str, ...] = ()
    example: str = ""
    values: tuple[float, ...] = ()
    is_array: bool = False
    is_picture: bool = False


@dataclass(frozen=True)
class Contents:
    """The places of a message in its own order, and whether it states a time and a frame."""

    places: tuple[Place, ...]
    has_stamp: bool
    frame: str


def contents_of(message: Any) -> Contents:
    """What a message holds; its stamp and frame_id are not among the places."""
    has_stamp = stamp_of(message) is not None
    places = []
    for place in _places(message, "", MAX_DEPTH):
        if not (has_stamp and STAMPS.match(place.path)):
            places.append(place)
        if len(places) == MAX_PLACES:
            places.append(Place("…", "more than are listed here"))
            break
    return Contents(tuple(places), has_stamp, frame_of(message))


def _places(value: Any, path: str, depth: int) -> Iterator[Place]:
    if depth == 0:
        yield Place(path, "more, too deep to be listed")
    elif isinstance(value, bool | int | float | np.number | np.bool_):
        number = _float(value)
        yield Place(path, "number", (path,) if path else (), f"{number:.6g}", (number,))
    elif isinstance(value, str):
        match = PICTURE_TEXTS.match(value)
        if match is None:
            yield Place(path, "text", (), repr(value[:40]))
        else:
            kind = "JPEG" if match["head"] == "/9j/" else "PNG"
            yield Place(path, f"a {kind} as base64 text", is_picture=True)
    elif isinstance(value, bytes | bytearray | memoryview):
        yield _bytes(bytes(value[:HEAD]), len(value), path)
    elif isinstance(value, Mapping):
        yield from _members(value, path, depth)
    elif hasattr(value, "DESCRIPTOR"):
        yield from _members({field.name: getattr(value, field.name) for field in value.DESCRIPTOR.fields}, path, depth)
    elif hasattr(value, "__dataclass_fields__"):
        members = {name: getattr(value, name) for name in value.__dataclass_fields__ if name[0] != "_"}
        yield from _members(members, path, depth)
    elif hasattr(value, "__len__") and hasattr(value, "__getitem__"):
        yield from _items(value, path, depth)


def _float(value: Any) -> float:
    """A number as a float; an integer that is beyond all floats, as JSON may hold, is infinite."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def _bytes(head: bytes, size: int, path: str) -> Place:
    """A place with bytes, of which the first ones say whether they are a picture."""
    kind = next((kind for magic, kind in PICTURES.items() if head.startswith(magic)), "")
    what = f"a {kind} of {size:,} bytes" if kind else f"{size:,} bytes"
    return Place(path, what, is_array=True, is_picture=bool(kind))


def _members(members: Mapping[Any, Any], path: str, depth: int) -> Iterator[Place]:
    for name, value in members.items():
        if isinstance(name, str) and NAME.fullmatch(name):
            yield from _places(value, f"{path}.{name}" if path else name, depth - 1)
        else:
            yield Place(f"{path}.{name}" if path else str(name), "a field whose name no mapping can write")


def _items(value: Sequence[Any], path: str, depth: int) -> Iterator[Place]:
    size = len(value)
    kind = str(value.dtype) if isinstance(value, np.ndarray) else ""
    if kind in ("uint8", "int8") and size >= FEWEST_BYTES:
        yield _bytes(np.asarray(value[:HEAD]).tobytes(), size, path)
    elif size == 0:
        yield Place(path, "an empty array in the first message", is_array=True)
    elif all(isinstance(item, bool | int | float | np.number | np.bool_) for item in value[: MAX_PLACES * MAX_ITEMS]):
        values = tuple(_float(item) for item in value[:MAX_EXAMPLE])
        shown = ", ".join(f"{item:.6g}" for item in values) + (", …" if size > MAX_EXAMPLE else "")
        what = f"{size:,} numbers" + (f" ({kind})" if kind else "")
        fields = tuple(f"{path}[{index}]" for index in range(size))
        yield Place(path, what, fields, f"[{shown}]", values, is_array=True)
    else:
        for index in range(min(size, MAX_ITEMS)):
            yield from _places(value[index], f"{path}[{index}]", depth - 1)
        if size > MAX_ITEMS:
            yield Place(f"{path}[{MAX_ITEMS}]", f"and {size - MAX_ITEMS:,} more like those before it")
