"""MCAP recordings: ROS 2, ROS 1, protobuf and JSON messages, single files and split folders, damaged ones too."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from mcap.records import Channel, Schema

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Finding, ImageSink, Recording, Source
from tactiledata.contract.schema import check_document
from tactiledata.errors import BrokenLog
from tactiledata.formats.base import Format, Inspection
from tactiledata.formats.described import described_trajectories
from tactiledata.formats.mcap_parts.bags import bag_sources, files_of, is_bag_file, is_bag_folder
from tactiledata.formats.mcap_parts.collect import SignalBuffer
from tactiledata.formats.mcap_parts.decode import Decoder, decoder_for, kind_of
from tactiledata.formats.mcap_parts.describe import backgrounds_of, description_of
from tactiledata.formats.mcap_parts.images import CameraBuffer, image_taker, stated_serials
from tactiledata.formats.mcap_parts.mapping_draft import Draft, Glimpse, draft_mapping
from tactiledata.formats.mcap_parts.playback import Handler, Playback
from tactiledata.formats.mcap_parts.readers import signal_taker
from tactiledata.formats.mcap_parts.roles import IMAGE_KINDS, ImageRole, Roles, Topic, roles_of
from tactiledata.formats.mcap_parts.survey import Survey, survey
from tactiledata.formats.mcap_parts.tally import Tally
from tactiledata.formats.mcap_parts.transform_tree import TransformTree

HostClock = Literal["log", "publish", "header", "auto"]
Buffer = SignalBuffer | CameraBuffer


class McapFormat(Format):
    """MCAP files and rosbag2 folders."""

    name = "mcap"
    title = "MCAP (ROS 2, ROS 1, protobuf, JSON), single files and rosbag2 folders"
    layout = """run.mcap                       one recording; its description in a metadata record named "tactiledata"
run.yaml                       or in a document beside it (schemas/log.json)
bag/metadata.yaml              a rosbag2 folder: its files are one recording
bag/bag_0.mcap, bag_1.mcap …"""

    def sniff(self, path: Path) -> bool:
        """Whether a file is an MCAP (or a bag that must become one), or a folder a bag or a collection of bags."""
        return is_bag_folder(path) if path.is_dir() else is_bag_file(path)

    def sources(self, path: Path) -> Sequence[Source]:
        """The bags, in natural order; the files of a split bag are one source."""
        try:
            return bag_sources(path, self.name)
        except OSError as error:
            raise BrokenLog(
                f"{path} cannot be read ({error.strerror})", "a readable folder", "Check its permissions."
            ) from error

    def read(self, source: Source, sink: ImageSink, mapping: Mapping[str, Any] | None = None) -> Recording:
        """A bag in one pass, its images into the sink, its signals kept compactly in memory.

        Raises
        ------
        BrokenLog
            Nothing in it is readable as a known stream, or a stream mixes frames and no mapping says which is meant.
        SchemaError
            A mapping, or a document beside the bag, does not fit.
        """
        inventories, findings = _surveys(source, mapping)
        path = Path(source.path)
        description, said = description_of(path, inventories, mapping)
        decoders = _Decoders()
        roles = roles_of(_topics(inventories, decoders), mapping)
        findings += [*said, *roles.findings]
        signals = [SignalBuffer(r.name, r.topic, r.columns, (), r.frame) for r in roles.signals]
        cameras = _cameras(roles, sink, description)
        if not (signals or cameras):
            raise _nothing_to_read(source, inventories, decoders, roles)
        trees = {
            role.name: TransformTree(role.frame or "", role.child_frame, buffer)
            for role, buffer in zip(roles.signals, signals, strict=True)
            if role.is_tree
        }
        handler_for = _handlers(roles, signals, cameras, decoders, trees)
        for inventory in inventories:
            findings += Playback(inventory, handler_for).run()
        buffers: list[Buffer] = [*signals, *cameras]
        findings += [finding for part in (*buffers, *trees.values()) for finding in part.findings()]
        findings += [*_empty(signals, cameras), *_foreign_wrench(signals, description)]
        if not (any(len(buffer.log) for buffer in signals) or any(camera.images for camera in cameras)):
            raise _nothing_read(source, findings)
        backgrounds = backgrounds_of(path, inventories, description)
        clock: HostClock = (mapping or {}).get("clock", "auto")
        return Recording(
            source,
            description,
            {buffer.name: _with_units(buffer, roles) for buffer in signals if len(buffer.log)},
            tuple(described_trajectories(description)),
            (*findings, *backgrounds.findings),
            clock,
            backgrounds.references,
            backgrounds.origins,
        )

    def inspect(self, source: Source, mapping: Mapping[str, Any] | None = None) -> Inspection:
        """All topics with a message of each, whether they have a role or not; reads the whole bag."""
        inventories, findings = _surveys(source, mapping)
        description, said = description_of(Path(source.path), inventories, mapping)
        decoders = _Decoders()
        tally = Tally(decoders.reason)
        for inventory in inventories:
            findings += Playback(inventory, tally.handler_for(inventory, decoders.get)).run()
        topics = _topics(inventories, decoders)
        roles = roles_of(topics, mapping)
        draft = _draft(topics, roles, tally.glimpses(), description)
        return Inspection(
            source,
            tally.topics(roles),
            (*findings, *said, *roles.findings),
            _facts(inventories, tally, description),
            draft.document,
            draft.text,
        )


class _Decoders:
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


def _surveys(source: Source, mapping: Mapping[str, Any] | None) -> tuple[list[Survey], list[Finding]]:
    """Inventories of all files of a recording that are MCAP files, and findings about the others."""
    if mapping is not None:
        check_document(mapping, "mapping", "the mapping")
    bag = files_of(Path(source.path))
    inventories: list[Survey] = []
    findings = list(bag.findings)
    faults: list[BrokenLog] = []
    for path in bag.files:
        try:
            inventories.append(survey(path))
        except BrokenLog as error:
            faults.append(error)
            findings.append(Finding("unreadable-file", "damage", str(error)))
    if not inventories:
        raise faults[0] if faults else BrokenLog(f"{source.path} holds no MCAP file", "at least one")
    return inventories, findings


def _topics(inventories: Sequence[Survey], decoders: _Decoders) -> list[Topic]:
    found: dict[str, Topic] = {}
    for inventory in inventories:
        for channel in inventory.channels.values():
            schema = inventory.schemas.get(channel.schema_id)
            is_readable = decoders.get(channel, schema) is not None
            if channel.topic not in found or (is_readable and not found[channel.topic].is_readable):
                found[channel.topic] = Topic(channel.topic, kind_of(schema), is_readable)
    return list(found.values())


def _cameras(roles: Roles, sink: ImageSink, description: LogDescription) -> list[CameraBuffer]:
    sensors = tuple(description.sensors)
    return [CameraBuffer(role, sink, sensors, len(roles.images) == 1) for role in roles.images]


def _draft(topics: list[Topic], roles: Roles, glimpses: Mapping[str, Glimpse], description: LogDescription) -> Draft:
    """A mapping to start from, with the serials that image topics say."""
    cameras = roles.images or tuple(ImageRole("", topic.name) for topic in topics if topic.kind in IMAGE_KINDS)
    serials = {}
    for role in cameras:
        frame = glimpses[role.topic].frame if role.topic in glimpses else ""
        stated = stated_serials(role, tuple(description.sensors), len(cameras) == 1, frame)
        serials[role.topic] = next(iter(stated.values()), "")
    return draft_mapping(topics, roles, glimpses, serials, description)


def _handlers(
    roles: Roles,
    signals: list[SignalBuffer],
    cameras: list[CameraBuffer],
    decoders: _Decoders,
    trees: Mapping[str, TransformTree],
) -> Callable[[Channel, Schema | None], Handler | None]:
    """What makes the handler of a channel, for all the roles that its topic has."""

    def handler_for(channel: Channel, schema: Schema | None) -> Handler | None:
        if channel.topic not in roles.topics:
            return None
        decoder = decoders.get(channel, schema)
        buffers: list[Buffer] = [*signals, *cameras]
        wanted = [buffer for buffer in buffers if _topic_of(buffer) == channel.topic]
        if decoder is None:
            reason = decoders.reason(channel, schema)
            return _spread([_refusing(buffer, reason) for buffer in wanted])
        takers: list[Handler] = []
        for role, buffer in zip(roles.signals, signals, strict=True):
            if role.is_tree and channel.topic in (role.topic, role.static_topic):
                takers.append(trees[role.name].taker(decoder, channel.topic == role.static_topic))
            elif role.topic == channel.topic:
                takers.append(signal_taker(role, decoder, buffer))
        takers += [image_taker(decoder, camera) for camera in cameras if camera.role.topic == channel.topic]
        return _spread(takers)

    return handler_for


def _topic_of(buffer: Buffer) -> str:
    return buffer.topic if isinstance(buffer, SignalBuffer) else buffer.role.topic


def _refusing(buffer: Buffer, reason: str) -> Handler:
    def refuse(content: bytes, start: int, stop: int, log_ns: int, publish_ns: int) -> None:
        buffer.faults.add(log_ns, reason)

    return refuse


def _spread(takers: list[Handler]) -> Handler:
    if len(takers) == 1:
        return takers[0]

    def take(content: bytes, start: int, stop: int, log_ns: int, publish_ns: int) -> None:
        for taker in takers:
            taker(content, start, stop, log_ns, publish_ns)

    return take


def _with_units(buffer: SignalBuffer, roles: Roles) -> Any:
    """The signal; units that a mapping states stay only with columns whose unit nobody else knows."""
    signal = buffer.signal()
    role = next(role for role in roles.signals if role.name == buffer.name)
    units = tuple(
        stated if known == "?" and stated else known
        for known, stated in zip(signal.units, role.units or ("",) * len(signal.units), strict=True)
    )
    return replace(signal, units=units)


def _empty(signals: list[SignalBuffer], cameras: list[CameraBuffer]) -> list[Finding]:
    names = [(buffer.name, buffer.topic) for buffer in signals if not len(buffer.log)]
    names += [(camera.role.camera, camera.role.topic) for camera in cameras if not camera.images]
    return [
        Finding("empty-stream", "warning", f"{topic} holds no message that could be read as {name}", name)
        for name, topic in names
    ]


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


def _nothing_to_read(source: Source, inventories: Sequence[Survey], decoders: _Decoders, roles: Roles) -> BrokenLog:
    """The error for a recording without a topic that the toolkit would read: what there is, and how to name it."""
    rows: dict[str, str] = {}
    for inventory in inventories:
        for channel in inventory.channels.values():
            schema = inventory.schemas.get(channel.schema_id)
            note = decoders.reason(channel, schema) or roles.notes.get(channel.topic, "")
            rows[channel.topic] = f"{channel.topic} ({kind_of(schema) or channel.message_encoding or 'no type'})" + (
                f": {note}" if note else ""
            )
    damage = [finding.message for inventory in inventories for finding in inventory.findings]
    listed = "; ".join(sorted(rows.values())[:12]) + ("; …" if len(rows) > 12 else "")
    if not rows:
        cause = f" ({'; '.join(damage)})" if damage else ""
        return BrokenLog(
            f"{source.path} has no topics{cause}", "a recording with messages", "Record it again.", topics=[]
        )
    missing = "; ".join(finding.message for finding in roles.findings)
    return BrokenLog(
        f"{source.path} holds no topic that is known as wrench, tcp, joints or a tactile camera. Its topics: {listed}"
        + (f". {missing}" if missing else ""),
        "at least one such stream",
        "Write a mapping that names the topics: `tactiledata inspect PATH --suggest-mapping`, then "
        "`tactiledata ingest PATH --mapping FILE`.",
        topics=sorted(rows),
    )


def _nothing_read(source: Source, findings: Sequence[Finding]) -> BrokenLog:
    reasons = "; ".join(finding.message for finding in findings if finding.severity != "info")
    return BrokenLog(
        f"{source.path}: not one message could be read ({reasons[:1000] or 'it holds none'})",
        "messages on the topics that are read",
        "`tactiledata inspect` shows what is in the file.",
        findings=list(findings),
    )


def _facts(inventories: Sequence[Survey], tally: Tally, description: LogDescription) -> dict[str, Any]:
    return {
        "files": [inventory.path.name for inventory in inventories],
        "bytes": sum(inventory.size for inventory in inventories),
        "profile": ", ".join(sorted({inventory.profile for inventory in inventories} - {""})),
        "library": ", ".join(sorted({inventory.library for inventory in inventories} - {""})),
        "messages": tally.messages,
        "start_ns": tally.start_ns,
        "end_ns": tally.end_ns,
        "attachments": sorted({name for inventory in inventories for name in inventory.attachments}),
        "metadata": sorted({record.name for inventory in inventories for record in inventory.metadata}),
        "sensors": sorted(description.sensors),
        "trajectories": len(described_trajectories(description)),
    }
