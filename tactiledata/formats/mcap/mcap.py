"""MCAP recordings: ROS 2, ROS 1, protobuf and JSON messages, single files and split folders, damaged ones too."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from mcap.records import Channel, Schema

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Finding, ImageSink, Recording, Source
from tactiledata.contract.schema import check_document
from tactiledata.errors import BrokenLog
from tactiledata.formats.base import Format, Inspection, NoSink
from tactiledata.formats.mcap.bags import bag_sources, files_of, is_bag_file, is_bag_folder
from tactiledata.formats.mcap.decode import kind_of
from tactiledata.formats.mcap.describe import backgrounds_of, description_of
from tactiledata.formats.mcap.joint_draft import DraftGrounds, joint_draft
from tactiledata.formats.mcap.passed_over import passed_over
from tactiledata.formats.mcap.playback import Handler, HandlerFor, Playback
from tactiledata.formats.mcap.reading import Decoders, Reading, spread
from tactiledata.formats.mcap.roles import Roles, Topic, roles_of
from tactiledata.formats.mcap.survey import COPY_AGAIN, Survey, survey
from tactiledata.formats.mcap.tally import Tally
from tactiledata.formats.reading.backgrounds import Backgrounds
from tactiledata.formats.reading.described import described_trajectories

HostClock = Literal["log", "publish", "header", "auto"]


class McapFormat(Format):
    """MCAP files and rosbag2 folders."""

    name = "mcap"
    title = "MCAP (ROS 2, ROS 1, protobuf, JSON), single files and rosbag2 folders"
    layout = """run.mcap                       one recording; its description in a metadata record named "tactiledata"
run.yaml                       or in a document beside it (schemas/log.json)
bag/metadata.yaml              a rosbag2 folder: its files are one recording
bag/bag_0.mcap, bag_1.mcap …"""
    judges_whole_folders = True

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

        Parameters
        ----------
        source : Source
            An MCAP file, or a folder of the files of one recording.
        sink : ImageSink
            Takes the images, in order.
        mapping : dict, optional
            A mapping document; it says which topics are which streams.

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
        decoders = Decoders()
        topics = _topics(inventories, decoders)
        roles = roles_of(topics, mapping)
        findings += [*said, *roles.findings, *passed_over(topics, roles, _counts(inventories), _stated(mapping))]
        reading = Reading(roles, decoders, sink, description)
        if reading.is_idle:
            raise _nothing_to_read(source, inventories, decoders, roles)
        for inventory in inventories:
            findings += Playback(inventory, reading.handler_for).run()
        reading.check_fields()
        findings += reading.findings()
        if reading.is_empty:
            raise _nothing_read(source, findings)
        backgrounds = backgrounds_of(path, inventories, description)
        return _recording(source, description, reading, findings, backgrounds, mapping)

    def inspect(
        self, source: Source, mapping: Mapping[str, Any] | None = None, sink: ImageSink | None = None
    ) -> Inspection:
        """All topics with a message of each, and what `read` would take of them; reads the whole bag.

        Parameters
        ----------
        source : Source
            One of `sources`.
        mapping : dict, optional
            A document that fits ``schemas/mapping.json``.
        sink : ImageSink, optional
            Takes the images in their order.
        """
        inventories, findings = _surveys(source, mapping)
        path = Path(source.path)
        description, said = description_of(path, inventories, mapping)
        decoders = Decoders()
        topics = _topics(inventories, decoders)
        roles = roles_of(topics, mapping)
        reading = Reading(roles, decoders, NoSink() if sink is None else sink, description)
        tally = Tally(decoders.reason)
        for inventory in inventories:
            findings += Playback(inventory, _both(tally.handler_for(inventory, decoders.get), reading)).run()
        reading.check_fields()
        grounds = DraftGrounds(source.key, topics, roles, tally.glimpses(), description)
        draft = joint_draft([grounds])
        left = passed_over(topics, roles, _counts(inventories), _stated(mapping))
        findings += [*said, *roles.findings, *left, *reading.findings()]
        backgrounds = backgrounds_of(path, inventories, description)
        recording = None
        if reading.is_idle or reading.is_empty:
            nothing = _nothing_read(source, findings)
            refusal = _nothing_to_read(source, inventories, decoders, roles) if reading.is_idle else nothing
            findings.append(Finding("would-not-be-read", "warning", f"ingest would not read it: {refusal}"))
        else:
            try:
                recording = _recording(source, description, reading, findings, backgrounds, mapping)
            except BrokenLog as error:
                findings.append(Finding("mixed-frames", "damage", str(error)))
        said_of_all = (*findings, *backgrounds.findings)
        facts = _facts(inventories, tally, description)
        streams = tally.topics(roles, reading.counts())
        return Inspection(source, streams, said_of_all, facts, draft.document, draft.text, recording, grounds)

    def draft(
        self, inspections: Sequence[Inspection], mapping: Mapping[str, Any] | None = None
    ) -> tuple[Mapping[str, Any] | None, str]:
        """One mapping for several recordings, as a document and as text; the text says which topics only some have.

        Parameters
        ----------
        inspections : sequence of Inspection
            Made by `inspect`.
        mapping : dict, optional
            The mapping by which they were made.
        """
        grounds = [item.grounds for item in inspections if isinstance(item.grounds, DraftGrounds)]
        if not grounds:
            return None, ""
        draft = joint_draft(grounds, mapping)
        return draft.document, draft.text


def _recording(
    source: Source,
    description: LogDescription,
    reading: Reading,
    findings: Sequence[Finding],
    backgrounds: Backgrounds,
    mapping: Mapping[str, Any] | None,
) -> Recording:
    """The recording of what was read.

    Raises
    ------
    BrokenLog
        A signal's samples are expressed in different frames, and nothing says which one is meant.
    """
    clock: HostClock = (mapping or {}).get("clock", "auto")
    return Recording(
        source,
        description,
        reading.signals(),
        tuple(described_trajectories(description)),
        (*findings, *backgrounds.findings),
        clock,
        backgrounds.references,
        backgrounds.origins,
    )


def _both(look: Callable[[Channel, Schema | None], Handler], reading: Reading) -> HandlerFor:
    """Handlers that show each message to an inspection, and read it where its topic has a role."""

    def handler_for(channel: Channel, schema: Schema | None) -> Handler:
        takers = (look(channel, schema), reading.handler_for(channel, schema))
        return spread([taker for taker in takers if taker is not None])

    return handler_for


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


def _topics(inventories: Sequence[Survey], decoders: Decoders) -> list[Topic]:
    found: dict[str, Topic] = {}
    for inventory in inventories:
        for channel in inventory.channels.values():
            schema = inventory.schemas.get(channel.schema_id)
            is_readable = decoders.get(channel, schema) is not None
            if channel.topic not in found or (is_readable and not found[channel.topic].is_readable):
                found[channel.topic] = Topic(channel.topic, kind_of(schema), is_readable)
    return list(found.values())


def _stated(mapping: Mapping[str, Any] | None) -> set[str]:
    """Streams that a mapping names; one that names images names all of them."""
    document = mapping or {}
    return {*document.get("signals", {}), *(["images"] if "images" in document else [])}


def _counts(inventories: Sequence[Survey]) -> dict[str, int]:
    """Messages of each topic, as the files count them; empty where one of them does not."""
    counts: Counter[str] = Counter()
    for inventory in inventories:
        if inventory.statistics is None:
            return {}
        stated = inventory.statistics.channel_message_counts
        for number, channel in inventory.channels.items():
            counts[channel.topic] += stated.get(number, 0)
    return dict(counts)


def _nothing_to_read(source: Source, inventories: Sequence[Survey], decoders: Decoders, roles: Roles) -> BrokenLog:
    """The error for a recording without a topic that the toolkit would read: what there is, and how to name it."""
    rows: dict[str, str] = {}
    for inventory in inventories:
        for channel in inventory.channels.values():
            schema = inventory.schemas.get(channel.schema_id)
            note = decoders.reason(channel, schema) or roles.notes.get(channel.topic, "")
            rows[channel.topic] = f"{channel.topic} ({kind_of(schema) or channel.message_encoding or 'no type'})" + (
                f": {note}" if note else ""
            )
    damage = [one.message.removesuffix(COPY_AGAIN) for inventory in inventories for one in inventory.findings]
    listed = "; ".join(sorted(rows.values())[:12]) + ("; …" if len(rows) > 12 else "")
    if not rows:
        cause = f" ({'; '.join(damage)})" if damage else ""
        remedy = "Copy it again from where it was recorded." if damage else "Record it again."
        return BrokenLog(f"{source.path} has no topics{cause}", "a recording with messages", remedy, topics=[])
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
