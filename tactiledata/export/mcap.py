"""MCAP files of ROS 2 messages, a file a recording, every sample at its native rate, for Foxglove and our reader."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import yaml
from numpy.typing import NDArray

from tactiledata.contract import ros2_messages
from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.provenance import json_bytes
from tactiledata.contract.simulated import recording_kind
from tactiledata.export.base import ExportedFile, Exporter, FileFacts
from tactiledata.export.episodes import Episodes
from tactiledata.export.message_types import image_type, message_maker, number_type
from tactiledata.export.pictures import png_bytes
from tactiledata.export.plan import ExportPlan
from tactiledata.export.recorded_streams import RecordedFrames, RecordedStamps, RecordedStreams
from tactiledata.export.recording_log import IMAGES_AT_ONCE, LoggedStream, number_stream, write_log
from tactiledata.formats.mcap.describe import RECORD_KEY, RECORD_NAME
from tactiledata.formats.mcap.roles import Topic, roles_of
from tactiledata.store.read.reader import Store

MAPPING = "mapping.yaml"
MAPPING_FORMAT = "tactiledata-mapping/1"
EXPORT_RECORD = "tactiledata.export"
"""Metadata record that holds what a log's description has no place for."""
DERIVED = "contact_wrench"
"""Ingest derives it from the readings; a reading of it beside them would be a second truth."""
MAPPED_NAME = re.compile(r"[a-z][a-z0-9_]{0,63}")
"""Names that a mapping may give."""


class McapExporter(Exporter):
    """Writes MCAP files of ROS 2 messages."""

    name = "mcap"
    title = "MCAP: ROS 2 messages at native rate, for Foxglove and for reading back"
    at_frames = False
    lost: ClassVar = (
        "Values interpolated at the frames: ingest computes them again from the samples.",
        "Captured moments without an image, values that a corpus annotates frame by frame, and meshes of `tactiledata "
        "replay`.",
        "Which clock wrote a stamp, where a recording had one clock only: its stamps become those of the headers, and "
        "the log times are the host's.",
        "What ingest left out (damage, samples of a broken clock) is not in the store, so neither is it here.",
        "Flags of bad trajectories, and that a recording was damaged: `tactiledata/trajectories.parquet` has the "
        "flags, but a store that is ingested from these files does not. Flag them there again.",
        "Names of columns that ROS 2 allows for no field (`a.b`): they come back as `values[0]` and so on.",
        "Files that a description names, other than pictures without contact: the store keeps no meshes of indenters.",
        "Parts of a split: a recording may hold touches of several. They stand in the metadata record "
        f"`{EXPORT_RECORD}` of each file.",
    )

    def __init__(self) -> None:
        self._recorded: RecordedStreams | None = None

    def _of(self, store: Store) -> RecordedStreams:
        """Return the recordings of a store; their tables are read once."""
        if self._recorded is None:
            self._recorded = RecordedStreams(store)
        return self._recorded

    def files(self, episodes: Episodes, plan: ExportPlan) -> Sequence[ExportedFile]:
        """Return a file for each recording."""
        recorded = self._of(episodes.store)
        return [
            ExportedFile(f"{name}.mcap", number, number + 1, int(recorded.frame_counts[number]))
            for number, name in enumerate(recorded.file_names)
        ]

    def write(self, episodes: Episodes, file: ExportedFile, path: Path, advance: Callable[[int], None]) -> FileFacts:
        """Write one recording.

        Parameters
        ----------
        episodes : Episodes
            What is exported.
        file : ExportedFile
            Which of it.
        path : Path
            Where the file is written.
        advance : callable
            Called with the number of frames written since the last call.
        """
        store, source, recorded = episodes.store, file.start, self._of(episodes.store)
        streams = [self._signal(store, name, *place) for name, place in recorded.signals(source).items()]
        for camera, frames in recorded.frames(source).items():
            streams.append(self._images(store, camera, frames, advance))
        description, others = recorded.description(source)
        own_record = {**self._own_record(episodes, source), "description": others}
        metadata = {EXPORT_RECORD: {"export": json_bytes(own_record).decode()}}
        if description:
            metadata = {RECORD_NAME: {RECORD_KEY: json_bytes(description).decode()}, **metadata}
        with path.open("wb") as stream:
            write_log(stream, streams, metadata, self._backgrounds(store, description), recorded.sources[source]["key"])
        return {"undescribed": int(not description)}

    def _signal(self, store: Store, name: str, stored: str, start: int, stop: int) -> LoggedStream:
        """Return a signal of a recording as a stream of messages."""
        signal = store.signal(stored)
        make = message_maker(name, signal.columns, signal.frame)
        kinds: tuple[Any, ...] = ("log", "publish", "header")
        recorded = (np.asarray(signal.stamps(each, start, stop)) for each in kinds)
        stamps = RecordedStamps.of(np.asarray(signal.t_ns(start, stop)), *recorded)
        return number_stream(number_type(name, signal.columns), make, stamps, np.asarray(signal.values(start, stop)))

    def _images(
        self, store: Store, camera: str, frames: RecordedFrames, advance: Callable[[int], None]
    ) -> LoggedStream:
        """Return a camera of a recording as a stream of messages; few pictures are read at once."""
        is_raw = frames.are_raw

        def messages() -> Iterator[Callable[[], bytes]]:
            """Yield a function for each message."""
            for start in range(0, len(frames.rows), IMAGES_AT_ONCE):
                payloads = store.encoded(frames.rows[start : start + IMAGES_AT_ONCE])
                for place, payload in enumerate(payloads, start):
                    yield partial(_image_message, frames, place, payload or b"", is_raw)
                advance(len(payloads))

        return LoggedStream(image_type(camera, is_raw), frames.stamps, messages)

    def _backgrounds(self, store: Store, description: Mapping[str, Any]) -> dict[str, bytes]:
        """Return the pictures without contact that a description names."""
        named = {sensor: facts.get("background") for sensor, facts in description.get("sensors", {}).items()}
        held = store.manifest["references"]
        return {
            name: png_bytes(store.reference(sensor).image) for sensor, name in named.items() if name and sensor in held
        }

    def _own_record(self, episodes: Episodes, source: int) -> dict[str, Any]:
        """Return where a recording came from, and in which part each of its touches is."""
        recorded = self._of(episodes.store)
        facts = recorded.sources[source]
        parts = dict(zip(episodes.trajectories.tolist(), episodes.parts, strict=True))
        return {
            "store_digest": episodes.store.digest,
            "recording": facts["key"],
            "recording_sha256": facts["sha256"],
            "recorded": recording_kind(json.loads(facts["description"] or "{}")),
            "format": facts["format"],
            "status": facts["status"],
            "trajectories": [
                {**{name: value for name, value in each.items() if name not in ("row", "source", "extra")},
                 "part": parts.get(each["row"], "")}
                for each in recorded.trajectories(source)
            ],
        }  # fmt: skip

    def finish(
        self,
        episodes: Episodes,
        files: Sequence[ExportedFile],
        facts: Callable[[], Iterator[FileFacts]],
        folder: Path,
    ) -> None:
        """Write a mapping where our reader could not tell by their names which topic is what.

        Parameters
        ----------
        episodes : Episodes
            What is exported.
        files : sequence of ExportedFile
            The large files.
        facts : callable
            Gives what was noted of each of them.
        folder : Path
            Where the export is made.
        """
        mapping = self._mapping(episodes)
        if mapping is not None:
            text = yaml.safe_dump(mapping, sort_keys=False, allow_unicode=True)
            write_atomic(folder / MAPPING, text.encode())

    def _mapping(self, episodes: Episodes) -> dict[str, Any] | None:
        """Return the mapping that reads the files back; ``None`` where the names of the topics say all."""
        store, recorded = episodes.store, self._of(episodes.store)
        topics: dict[str, str] = {}
        signals: dict[str, Any] = {}
        cameras: dict[str, Any] = {}
        for source in range(len(recorded.sources)):
            found = recorded.signals(source)
            for name, (stored, _, _) in found.items():
                signal = store.signal(stored)
                logged = number_type(name, signal.columns)
                topics[logged.topic] = logged.kind
                must_be_mapped = logged.is_own or (name == DERIVED and "wrench" not in found)
                if must_be_mapped and MAPPED_NAME.fullmatch(name):
                    units = [unit if unit != "?" else "1" for unit in signal.units]
                    signals[name] = {"topic": logged.topic, "fields": list(logged.fields), "units": units}
            for camera, frames in recorded.frames(source).items():
                logged = image_type(camera, frames.are_raw)
                topics[logged.topic] = logged.kind
                cameras[camera] = {"topic": logged.topic}
        guessed = roles_of([Topic(topic, kind.replace("/msg/", "/")) for topic, kind in topics.items()])
        are_guessed = {role.camera: role.topic for role in guessed.images} == {
            camera: entry["topic"] for camera, entry in cameras.items()
        }
        if not signals and are_guessed:
            return None
        document: dict[str, Any] = {"format": MAPPING_FORMAT}
        if signals:
            document["signals"] = signals
        if not are_guessed:
            document["images"] = {name: entry for name, entry in cameras.items() if MAPPED_NAME.fullmatch(name)}
        return document

    def left_out(self, episodes: Episodes) -> dict[str, int]:
        """Return how many captured moments have no image; all images go out, readable or not."""
        lacking = episodes.store.n_frames - int(self._of(episodes.store).frame_counts.sum())
        return {"no image recorded": lacking} if lacking else {}

    def kept_as(self, stream: str, episodes: Episodes) -> str:
        """Return the topic of a stream."""
        store = episodes.store
        if stream in store.cameras:
            return image_type(stream, True).topic
        base = stream.partition("@")[0]
        if stream not in store.signal_names:
            return "not kept"
        return number_type(base, store.signal(stream).columns).topic

    def remarks(self, episodes: Episodes) -> list[str]:
        """Return how the files are read back, and what cannot be."""
        mapping = self._mapping(episodes)
        how = f" --mapping {MAPPING}" if mapping is not None else ""
        return [
            f"`tactiledata ingest . --store back.zarr{how}` reads the files back, times and bytes of pictures as they "
            "were.",
            f"The topic of {DERIVED} is for viewers: ingest derives it again.",
        ]

    def snippet(self, episodes: Episodes, files: Sequence[ExportedFile]) -> str:
        """Return lines that list the topics of the first file."""
        return "\n".join(
            [
                "from mcap.reader import make_reader",
                "",
                f"with open({files[0].path!r}, 'rb') as stream:",
                "    summary = make_reader(stream).get_summary()",
                "for number, channel in summary.channels.items():",
                "    print(channel.topic, summary.statistics.channel_message_counts.get(number, 0))",
            ]
        )


def _image_message(frames: RecordedFrames, place: int, payload: bytes, is_raw: bool) -> bytes:
    """Return a picture as CDR bytes; raw ones of a camera that has both kinds become PNG."""
    stamp, sensor = int(frames.stamps.header_ns[place]), frames.sensors[place]
    height, width = frames.sizes[place].tolist()
    if is_raw:
        return ros2_messages.raw_image(stamp, sensor, "rgb8", height, width, payload)
    if frames.encodings[place] == "raw":
        pixels: NDArray[np.uint8] = np.frombuffer(payload, np.uint8).reshape(height, width, 3)
        return ros2_messages.compressed_image(stamp, sensor, "png", png_bytes(pixels))
    return ros2_messages.compressed_image(stamp, sensor, frames.encodings[place], payload)
