"""Counts, rates and an example of every topic, for a person who wonders what is in a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from mcap.records import Channel, Schema

from tactiledata.contract.wording import counted
from tactiledata.formats.base import TopicInfo
from tactiledata.formats.mcap.contents import Contents, contents_of
from tactiledata.formats.mcap.decode import FAULTS, Decoder, encoding_of, kind_of
from tactiledata.formats.mcap.message_fields import frame_of, value_at
from tactiledata.formats.mcap.playback import Handler
from tactiledata.formats.mcap.roles import TF_KIND, Roles
from tactiledata.formats.mcap.survey import Survey
from tactiledata.formats.mcap.undecoded import reason_of
from tactiledata.formats.mcap.unread_topics import Glimpse
from tactiledata.formats.reading.natural_order import natural_key
from tactiledata.formats.reading.stream_rate import has_times, rate_of

EXAMPLE_LENGTH = 240
DEPTH = 6
SHOWN_ITEMS = 8
SHOWN_TEXT = 60
TREE_MESSAGES = 50
"""Messages of a tree of transforms that are looked into: its edges come in several messages."""


@dataclass
class _Row:
    kind: str
    encoding: str
    messages: int = 0
    start_ns: int = 0
    end_ns: int = 0
    note: str = ""
    example: str = ""
    frame: str = ""
    joints: tuple[str, ...] = ()
    parents: dict[str, str] = field(default_factory=dict)
    contents: Contents | None = None

    @property
    def rate(self) -> float | None:
        """Hz, from the first message to the last; ``None`` where their log times are no times."""
        return rate_of(self.messages, self.start_ns, self.end_ns)

    def look(self, message: Any) -> None:
        """Note what a mapping would need of a decoded message."""
        self.contents = self.contents or contents_of(message)
        self.example = self.example or shortened(message)
        self.frame = self.frame or frame_of(message)
        if self.kind == "sensor_msgs/JointState" and not self.joints:
            self.joints = tuple(value_at(message, ("name",)))
        if self.kind == TF_KIND:
            for transform in value_at(message, ("transforms",)):
                child = str(value_at(transform, ("child_frame_id",))).strip("/")
                self.parents.setdefault(child, frame_of(transform).strip("/"))


class Tally:
    """Rows of `tactiledata inspect`, filled while a recording is played.

    Parameters
    ----------
    reason : callable
        Channel and schema -> why its messages cannot be decoded; empty where they can.
    """

    def __init__(self, reason: Callable[[Channel, Schema | None], str]) -> None:
        self._reason = reason
        self._rows: dict[str, _Row] = {}

    def handler_for(
        self, inventory: Survey, decoder_of: Callable[[Channel, Schema | None], Decoder | None]
    ) -> Callable[[Channel, Schema | None], Handler]:
        """What makes the handlers for one file."""

        def handler_for(channel: Channel, schema: Schema | None) -> Handler:
            row = self._rows.setdefault(channel.topic, _Row(kind_of(schema), encoding_of(channel, schema)))
            row.note = row.note or self._reason(channel, schema)
            decoder = decoder_of(channel, schema)
            faults = 0

            def take(content: bytes, start: int, stop: int, log_ns: int, publish_ns: int) -> None:
                nonlocal faults
                if not row.messages:
                    row.start_ns = row.end_ns = log_ns
                row.messages += 1
                row.start_ns, row.end_ns = min(row.start_ns, log_ns), max(row.end_ns, log_ns)
                is_wanted = not row.example or (row.kind == TF_KIND and row.messages <= TREE_MESSAGES)
                if decoder is not None and is_wanted and faults < SHOWN_ITEMS:
                    try:
                        row.look(decoder.decode(content[start:stop]))
                    except FAULTS as error:
                        faults += 1
                        row.note = f"a message that does not decode as {row.kind}: {reason_of(error)}"[:EXAMPLE_LENGTH]

            return take

        for channel in inventory.channels.values():
            handler_for(channel, inventory.schemas.get(channel.schema_id))
        return handler_for

    @property
    def messages(self) -> int:
        """Messages of all topics."""
        return sum(row.messages for row in self._rows.values())

    @property
    def start_ns(self) -> int | None:
        """Log time of the first message, ns."""
        return min((row.start_ns for row in self._rows.values() if row.messages), default=None)

    @property
    def end_ns(self) -> int | None:
        """Log time of the last message, ns."""
        return max((row.end_ns for row in self._rows.values() if row.messages), default=None)

    def glimpses(self) -> dict[str, Glimpse]:
        """What a draft of a mapping needs of each topic."""
        return {
            name: Glimpse(
                row.frame, row.joints, row.parents, row.encoding, row.note, row.messages, row.rate, row.contents
            )
            for name, row in self._rows.items()
        }

    def topics(self, roles: Roles, counts: Mapping[tuple[str, str], int]) -> tuple[TopicInfo, ...]:
        """The rows, in natural order of their topics.

        Parameters
        ----------
        roles : Roles
        counts : dict, (topic, name of a signal or camera) -> samples or pictures that were read of it
        """
        return tuple(
            TopicInfo(
                name,
                row.kind,
                row.encoding,
                row.messages,
                row.rate,
                roles.label(name, {role for (topic, role), count in counts.items() if topic == name and not count}),
                "; ".join(filter(None, (*_shortfalls(name, row, counts), row.note or roles.notes.get(name, "")))),
                row.example,
                has_times(row.messages, row.start_ns, row.end_ns),
            )
            for name, row in sorted(self._rows.items(), key=lambda item: natural_key(item[0]))
        )


def _shortfalls(topic: str, row: _Row, counts: Mapping[tuple[str, str], int]) -> Iterator[str]:
    """What a topic was named as and did not give, in full or in part."""
    for (named, role), count in counts.items():
        if named == topic and not count and row.messages:
            yield f"named as {role}, and not one of its messages can be read"
        elif named == topic and row.kind != TF_KIND and count < row.messages:
            yield f"{counted(count, 'message')} of {row.messages:,} can be read as {role}"


def shortened(message: Any) -> str:
    """A decoded message on one line, long values cut."""
    text = _shown(message, DEPTH)
    return text if len(text) <= EXAMPLE_LENGTH else text[: EXAMPLE_LENGTH - 1] + "…"


def _shown(value: Any, depth: int) -> str:
    if depth == 0:
        return "…"
    if isinstance(value, bytes | bytearray | memoryview):
        return f"<{len(value)} bytes>"
    if isinstance(value, str):
        text = value if len(value) <= SHOWN_TEXT else f"{value[: SHOWN_TEXT - 1]}… ({len(value)} characters)"
        return repr(text)
    if isinstance(value, Mapping):
        return _braced(list(value.items()), depth)
    if hasattr(value, "DESCRIPTOR"):
        return _braced([(field.name, getattr(value, field.name)) for field in value.DESCRIPTOR.fields], depth)
    if hasattr(value, "__dataclass_fields__"):
        return _braced([(name, getattr(value, name)) for name in value.__dataclass_fields__ if name[0] != "_"], depth)
    if hasattr(value, "__len__") and hasattr(value, "__getitem__"):
        if len(value) > SHOWN_ITEMS:
            return f"<{len(value)} items>"
        return f"[{', '.join(_shown(item, depth - 1) for item in value)}]"
    return str(value)


def _braced(items: list[tuple[Any, Any]], depth: int) -> str:
    shown = [f"{name}: {_shown(value, depth - 1)}" for name, value in items[: 3 * SHOWN_ITEMS]]
    return "{" + ", ".join(shown) + (", …" if len(items) > 3 * SHOWN_ITEMS else "") + "}"
