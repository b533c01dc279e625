"""The topics that have a role, read into buffers: one way for `read` and `inspect`, so that both say the same."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from mcap.records import Channel, Schema

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Finding, ImageSink, Signal
from tactiledata.errors import BrokenLog, SchemaError
from tactiledata.formats.mcap.collect import SignalBuffer
from tactiledata.formats.mcap.decode import Decoder, decoder_for
from tactiledata.formats.mcap.images import CameraBuffer, image_taker
from tactiledata.formats.mcap.message_fields import steps_of
from tactiledata.formats.mcap.playback import Handler
from tactiledata.formats.mcap.readers import signal_taker
from tactiledata.formats.mcap.roles import Roles, SignalRole
from tactiledata.formats.mcap.transform_tree import TransformTree

Buffer = SignalBuffer | CameraBuffer


class Decoders:
    """Decoders of channels, made once each, and the reasons where there is none."""

    def __init__(self) -> None:
        self._known: dict[tuple[str, str, str, bytes], Decoder | BrokenLog] = {}

    def _look_up(self, channel: Channel, schema: Schema | None) -> Decoder | BrokenLog:
        key = (
            channel.message_encoding,
            *(("", "", b"") if schema is None else (schema.name, schema.encoding, schema.data)),
        )
        if key not in self._known:
            try:
                self._known[key] = decoder_for(channel, schema)
            except BrokenLog as error:
                self._known[key] = error
        return self._known[key]

    def get(self, channel: Channel, schema: Schema | None) -> Decoder | None:
        """The decoder, or ``None`` where there is none."""
        found = self._look_up(channel, schema)
        return found if isinstance(found, Decoder) else None

    def reason(self, channel: Channel, schema: Schema | None) -> str:
        """Why there is no decoder; empty where there is one."""
        found = self._look_up(channel, schema)
        return str(found) if isinstance(found, BrokenLog) else ""


class Reading:
    """What a recording's topics give in the roles that they have.

    Parameters
    ----------
    roles : Roles
    decoders : Decoders
    sink : ImageSink
        Takes the pictures.
    description : LogDescription
        What the recording says of itself: its sensors, and the frame of its wrench.
    """

    def __init__(self, roles: Roles, decoders: Decoders, sink: ImageSink, description: LogDescription) -> None:
        sensors = tuple(description.sensors)
        self._roles, self._decoders, self._description = roles, decoders, description
        self._signals = [SignalBuffer(r.name, r.topic, r.columns, (), r.frame) for r in roles.signals]
        self._cameras = [CameraBuffer(role, sink, sensors, len(roles.images) == 1) for role in roles.images]
        self._trees = {
            role.name: TransformTree(role.frame or "", role.child_frame, buffer)
            for role, buffer in zip(roles.signals, self._signals, strict=True)
            if role.is_tree
        }

    @property
    def is_idle(self) -> bool:
        """Whether no topic has a role."""
        return not (self._signals or self._cameras)

    @property
    def is_empty(self) -> bool:
        """Whether not one message was read."""
        return not any(count for _, _, count in self._counted())

    def handler_for(self, channel: Channel, schema: Schema | None) -> Handler | None:
        """What takes the messages of a channel, for all the roles that its topic has; ``None`` where it has none."""
        if channel.topic not in self._roles.topics:
            return None
        decoder = self._decoders.get(channel, schema)
        if decoder is None:
            reason = self._decoders.reason(channel, schema)
            buffers: list[Buffer] = [*self._signals, *self._cameras]
            return spread([_refusing(buffer, reason) for buffer in buffers if _topic_of(buffer) == channel.topic])
        takers: list[Handler] = []
        for role, buffer in zip(self._roles.signals, self._signals, strict=True):
            if role.is_tree and channel.topic in (role.topic, role.static_topic):
                takers.append(self._trees[role.name].taker(decoder, channel.topic == role.static_topic))
            elif role.topic == channel.topic:
                takers.append(signal_taker(role, decoder, buffer))
        takers += [image_taker(decoder, camera) for camera in self._cameras if camera.role.topic == channel.topic]
        return spread(takers)

    def signals(self) -> dict[str, Signal]:
        """The signals that have samples, by name.

        Raises
        ------
        BrokenLog
            A signal's samples are expressed in different frames, and nothing says which one is meant.
        """
        roles = {role.name: role for role in self._roles.signals}
        return {
            buffer.name: _with_units(buffer.signal(), roles[buffer.name]) for buffer in self._signals if len(buffer.log)
        }

    def check_fields(self) -> None:
        """Refuse a mapping whose fields are in none of the messages that it names.

        Raises
        ------
        SchemaError
            A path leads to an attribute of the objects that hold the messages, or nowhere.
        """
        for role, buffer in zip(self._roles.signals, self._signals, strict=True):
            error = buffer.misnamed
            if role.fields and error is not None and not len(buffer.log):
                row = [steps_of(field) for field in role.fields].index(error.steps)
                named = role.fields[row]
                raise SchemaError(
                    f"the mapping's signals.{role.name} names {named!r}; in the messages of {role.topic}, {error}",
                    error.expected,
                    "`tactiledata inspect` without the mapping shows a message of every topic, with its fields.",
                    path=f"$.signals.{role.name}.fields[{row}]",
                    topic=role.topic,
                )

    def counts(self) -> dict[tuple[str, str], int]:
        """How many samples or pictures were taken, by topic and by the name of the signal or camera."""
        return {(topic, name): count for name, topic, count in self._counted()}

    def findings(self) -> list[Finding]:
        """What was wrong with the messages that were read."""
        parts: list[Buffer | TransformTree] = [*self._signals, *self._cameras, *self._trees.values()]
        found = [finding for part in parts for finding in part.findings()]
        empty = [
            Finding("empty-stream", "warning", f"{topic} holds no message that could be read as {name}", name)
            for name, topic, count in self._counted()
            if not count
        ]
        return [*found, *empty, *_foreign_wrench(self._signals, self._description)]

    def _counted(self) -> Iterator[tuple[str, str, int]]:
        for buffer in self._signals:
            yield buffer.name, buffer.topic, len(buffer.log)
        for camera in self._cameras:
            yield camera.role.camera, camera.role.topic, camera.images


def spread(takers: Sequence[Handler]) -> Handler:
    """One handler that hands each message to several."""
    if len(takers) == 1:
        return takers[0]

    def take(content: bytes, start: int, stop: int, log_ns: int, publish_ns: int) -> None:
        for taker in takers:
            taker(content, start, stop, log_ns, publish_ns)

    return take


def _topic_of(buffer: Buffer) -> str:
    return buffer.topic if isinstance(buffer, SignalBuffer) else buffer.role.topic


def _refusing(buffer: Buffer, reason: str) -> Handler:
    def refuse(content: bytes, start: int, stop: int, log_ns: int, publish_ns: int) -> None:
        buffer.faults.add(log_ns, reason)

    return refuse


def _with_units(signal: Signal, role: SignalRole) -> Signal:
    """The signal; units that a mapping states stay only with columns whose unit nobody else knows."""
    if not role.units or role.is_rotation_vector:
        return signal
    units = tuple(
        stated if known == "?" and stated else known for known, stated in zip(signal.units, role.units, strict=True)
    )
    return replace(signal, units=units)


def _foreign_wrench(signals: list[SignalBuffer], description: LogDescription) -> list[Finding]:
    """A wrench in another frame than the one that the description's transforms refer to."""
    stated = description.wrench.get("frame")
    return [
        Finding(
            "wrench-frame",
            "warning",
            f"{buffer.topic} is in frame {frame!r}, and the description says {stated!r}: tcp_from_ft may not fit",
            buffer.name,
        )
        for buffer in signals
        for frame in buffer.frames
        if buffer.name == "wrench" and stated and frame != stated
    ]
