"""Messages of every encoding that the toolkit reads, as objects or dictionaries with named fields.

Types are taken from the schema text of each file, never from a table of ours: the same name may mean another layout in
another file. rosbags turns that text into Python code, so what it parsed is checked before it is turned.
"""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from mcap.exceptions import McapError
from mcap.records import Channel, Schema
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.base import TypesysError
from rosbags.typesys.store import Typestore

from tactiledata.errors import BrokenLog

MAX_SCHEMA_BYTES = 2**20
FAULTS = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    LookupError,
    RecursionError,
    SyntaxError,
    TypeError,
    ValueError,
    struct.error,
    McapError,
    SerdeError,
    TypesysError,
)
"""What decoders raise on a message, or a type, that a stranger wrote."""

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*")
_FIELD = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_IDL_SEPARATOR = re.compile(r"^=+\s*\nIDL: .*$", re.MULTILINE)
_BASE, _NAMED, _ARRAY, _SEQUENCE = 1, 2, 3, 4


@dataclass(frozen=True)
class Decoder:
    """How the messages of one channel are read.

    Parameters
    ----------
    kind : str
        The type as ``package/Type`` or ``package.Type``.
    encoding : str
        For people, for example ``"cdr/ros2msg"``.
    decode : callable
        Payload -> message; raises one of `FAULTS`.
    layout : tuple of (path, type)
        The flattened fields of a ROS 2 type; empty where messages are not CDR.
    """

    kind: str
    encoding: str
    decode: Callable[[bytes], Any]
    layout: tuple[tuple[str, str], ...] = ()


def kind_of(schema: Schema | None) -> str:
    """A type's name without the ``/msg/`` that some writers put into it."""
    return "" if schema is None else re.sub(r"/(msg|action)/", "/", schema.name, count=1)


def encoding_of(channel: Channel, schema: Schema | None) -> str:
    """Message and schema encoding, for people."""
    return f"{channel.message_encoding or '?'}/{schema.encoding or '?'}" if schema else channel.message_encoding or "?"


def decoder_for(channel: Channel, schema: Schema | None) -> Decoder:
    """The decoder of a channel.

    Raises
    ------
    BrokenLog
        The encoding is unknown, its package is not installed, or the schema cannot be read; the reason is for people.
    """
    encoding, kind = encoding_of(channel, schema), kind_of(schema)
    try:
        if channel.message_encoding == "json":
            return Decoder(kind or "json", encoding, _json_message)
        if schema is None:
            raise BrokenLog(f"{channel.topic} has no schema, and {channel.message_encoding!r} messages need one")
        if len(schema.data) > MAX_SCHEMA_BYTES:
            raise BrokenLog(f"the schema of {channel.topic} has {len(schema.data)} bytes")
        wanted = (channel.message_encoding, schema.encoding)
        if wanted in (("cdr", "ros2msg"), ("cdr", "ros2idl"), ("ros1", "ros1msg")):
            return _ros_decoder(schema.name, schema.encoding, bytes(schema.data), kind, encoding)
        if wanted == ("protobuf", "protobuf"):
            return Decoder(kind, encoding, _protobuf(schema))
    except BrokenLog:
        raise
    except FAULTS as error:
        reason = " ".join(str(error).split())[:160] or type(error).__name__
        raise BrokenLog(f"the schema of {channel.topic} ({kind}) cannot be read: {reason}") from error
    raise BrokenLog(
        f"{channel.topic} is encoded as {encoding!r}",
        "cdr with ros2msg or ros2idl, ros1, protobuf or json",
        "Convert the recording, or record it again with a usual encoding.",
    )


def _json_message(payload: bytes) -> Any:
    """A message from JSON; a number with more digits than Python reads is a fault of the message."""
    try:
        return json.loads(payload)
    except (json.JSONDecodeError, UnicodeDecodeError):
        raise
    except ValueError as error:
        raise ValueError("a number in it has too many digits") from error


# ROS


@lru_cache(maxsize=256)
def _ros_decoder(name: str, schema_encoding: str, definition: bytes, kind: str, encoding: str) -> Decoder:
    """A decoder, made once for each definition: many files of one robot carry the same ones."""
    text = definition.decode("utf-8")
    if re.search(r"^---\s*$", text, re.MULTILINE):
        raise BrokenLog(f"{kind} is a service or action: its schema does not say how its events are laid out")
    if schema_encoding == "ros2idl":
        types: dict[str, Any] = {}
        for part in _IDL_SEPARATOR.split(text):
            if part.strip():
                types.update(get_types_from_idl(part))
    else:
        types = dict(get_types_from_msg(text, name))
    found = next((known for known in types if known.replace("/msg/", "/") == kind), None)
    if found is None:
        raise BrokenLog(f"the schema of {kind} does not define it; it defines {', '.join(sorted(types)[:5])}")
    is_ros1 = schema_encoding == "ros1msg"
    _complete(types, get_typestore(Stores.ROS1_NOETIC if is_ros1 else Stores.ROS2_HUMBLE))
    _check_types(types)
    layout = tuple(_flat(found, types))
    return Decoder(kind, encoding, _RosMessages(types, found, is_ros1), () if is_ros1 else layout)


class _RosMessages:
    """A decoder of ROS messages that is compiled when its first message comes: most topics are read without it."""

    def __init__(self, types: dict[str, Any], name: str, is_ros1: bool) -> None:
        self._types, self._name, self._is_ros1 = types, name, is_ros1
        self._decode: Callable[[bytes, str], Any] | None = None
        self._fault = ""

    def __call__(self, payload: bytes) -> Any:
        if self._decode is None:
            self._compile()
        if self._decode is None:
            raise ValueError(self._fault)
        return self._decode(payload, self._name)

    def _compile(self) -> None:
        if self._fault:
            return
        store = Typestore()
        try:
            store.register(self._types)
            store.get_msgdef(self._name)
        except FAULTS as error:
            self._fault = f"the type {self._name} cannot be compiled: {error}"
            return
        self._decode = store.deserialize_ros1 if self._is_ros1 else store.deserialize_cdr


def _complete(types: dict[str, Any], usual: Typestore) -> None:
    """Types that the text uses and does not define, as ROS defines them."""
    open_names = list(types)
    while open_names:
        for _, description in types[open_names.pop()][1]:
            used = description[1] if description[0] == _NAMED else None
            if description[0] in (_ARRAY, _SEQUENCE) and description[1][0][0] == _NAMED:
                used = description[1][0][1]
            if used is not None and used not in types:
                if used not in usual.fielddefs:
                    raise BrokenLog(f"the type {used} is used and not defined")
                types[used] = usual.fielddefs[used]
                open_names.append(used)


def _check_types(types: Mapping[str, Any]) -> None:
    """Refuses whatever could become code: names that are no names, sizes that are no numbers."""
    for name, (constants, fields) in types.items():
        plain = _NAME.fullmatch(name) is not None
        for constant, base, value in constants:
            plain &= _FIELD.fullmatch(constant) is not None and _FIELD.fullmatch(base) is not None
            plain &= type(value) in (int, float, bool, str)
        for field, (node, inner) in fields:
            plain &= _FIELD.fullmatch(field) is not None
            if node in (_ARRAY, _SEQUENCE):
                (node, inner), count = inner
                plain &= type(count) is int and 0 <= count <= 2**24
            plain &= (
                _NAME.fullmatch(inner) is not None
                if node == _NAMED
                else _FIELD.fullmatch(inner[0]) is not None and type(inner[1]) is int
            )
        if not plain:
            raise BrokenLog(f"the type {name[:60]!r} has names or sizes that no message type has")


def _flat(name: str, types: Mapping[str, Any], prefix: str = "", depth: int = 0) -> list[tuple[str, str]]:
    if depth > 20:
        raise BrokenLog(f"the type {name} contains itself")
    fields: list[tuple[str, str]] = []
    for field, (node, inner) in types[name][1]:
        path = f"{prefix}{field}"
        if node == _NAMED:
            fields += _flat(inner, types, f"{path}.", depth + 1)
        elif node == _BASE:
            fields.append((path, inner[0]))
        else:
            (kind, element), count = inner
            mark = f"[{count}]" if node == _ARRAY else "[]"
            fields.append((path, (element if kind == _NAMED else element[0]) + mark))
    return fields


# protobuf


def _protobuf(schema: Schema) -> Callable[[bytes], Any]:
    """A decoder in a descriptor pool of its own, so that types of different files cannot meet."""
    try:
        from google.protobuf.message import DecodeError
        from mcap_protobuf.decoder import DecoderFactory
    except ImportError as error:
        raise BrokenLog(
            f"{schema.name} is encoded as protobuf, whose package is not installed",
            "the package mcap-protobuf-support",
            "Install it with `pip install mcap-protobuf-support`.",
        ) from error
    try:
        decode = DecoderFactory().decoder_for("protobuf", schema)
    except DecodeError as error:
        raise BrokenLog(f"the descriptor of {schema.name} is damaged") from error
    assert decode is not None

    def decoded(payload: bytes) -> Any:
        try:
            return decode(payload)
        except DecodeError as error:
            raise ValueError(f"not a {schema.name}: {error}") from error

    return decoded
