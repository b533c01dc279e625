"""Writing of a recording as a ROS 2 MCAP, as a recorder on the rig would have written it."""

from __future__ import annotations

import heapq
import secrets
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from tactiledata.contract.atomic import sync_folder
from tactiledata.contract.provenance import json_bytes
from tactiledata.rig.logs import ros2_messages
from tactiledata.rig.logs.encode import encoded, raw_bytes, turned
from tactiledata.rig.logs.imperfections import arrival_times
from tactiledata.rig.logs.tape import Shot, Tape

Message = tuple[int, int, int, Callable[[], bytes]]
"""Log time in ns, stream number, sequence number, and a function that gives the bytes."""
OTHER_ORDER = {"rgb8": "bgr8", "bgr8": "rgb8"}
PROFILE = "ros2"
LIBRARY = "tactiledata rig"


def write_mcap(tape: Tape, path: Path, progress: Callable[[int], None]) -> None:
    """Write a tape as an MCAP file, whole or not at all.

    Parameters
    ----------
    tape : Tape
        The recording.
    path : Path
        The file.
    progress : callable
        Called with the number of pictures written since the last call.
    """
    beside = path.parent / f".{path.name[:60]}.{secrets.token_hex(4)}.part"
    try:
        with beside.open("wb") as stream:
            _write(tape, stream, progress)
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)
    sync_folder(path.parent)


def _write(tape: Tape, stream: Any, progress: Callable[[int], None]) -> None:
    """Write description, streams and pictures into an open file, in the order of arrival."""
    setup = tape.scenario.recordings
    writer = Writer(
        stream,
        chunk_size=setup.chunk_size,
        compression=CompressionType[setup.compression.upper()],
        enable_crcs=setup.crcs,
    )
    writer.start(profile=PROFILE, library=LIBRARY)
    if setup.describe:
        # first, so that a file that is cut still says what it is
        _describe(tape, writer)
    # a channel for each stream of numbers and each camera
    channels: list[int] = []
    schemas: dict[str, int] = {}
    streams: list[Iterator[Message]] = []

    def add_channel(topic: str, kind: str) -> int:
        """Return the number of a new channel for messages of a kind."""
        if kind not in schemas:
            schemas[kind] = writer.register_schema(kind, "ros2msg", ros2_messages.definition(kind))
        channels.append(writer.register_channel(topic, "cdr", schemas[kind]))
        return len(channels) - 1

    for name in tape.signals:
        number = add_channel(ros2_messages.TOPICS[name], ros2_messages.KINDS[name])
        streams.append(_signal_messages(tape, name, number))
    for serial in sorted({shot.sensor for shot in tape.shots}):
        number = add_channel(*_image_channel(tape, serial))
        streams.append(_image_messages(tape, serial, number, progress))
    for log_ns, number, sequence, make in tape.disordered(heapq.merge(*streams), purpose=1):
        writer.add_message(channels[number], log_ns, make(), log_ns, sequence)
    writer.finish()


def _signal_messages(tape: Tape, name: str, number: int) -> Iterator[Message]:
    """Yield the messages of a stream of numbers in the order of arrival."""
    samples = tape.signals[name]
    arrivals = arrival_times(samples.host_ns, tape.clock(name), tape.rng(10 + number))
    message = ros2_messages.serialise(name, samples.stamp_ns, samples.values)
    for index, log_ns in enumerate(arrivals.tolist()):
        yield log_ns, number, index, partial(message, index)


def _image_channel(tape: Tape, serial: str) -> tuple[str, str]:
    """Return topic and message type of a camera."""
    if tape.scenario.images.encoding == "raw":
        return f"/digit/{serial}/image_raw", "sensor_msgs/msg/Image"
    return f"/digit/{serial}/image_raw/compressed", "sensor_msgs/msg/CompressedImage"


def _image_messages(tape: Tape, serial: str, number: int, progress: Callable[[int], None]) -> Iterator[Message]:
    """Yield the messages of a camera in the order of arrival, without lost images."""
    import numpy as np

    shots = [shot for shot in tape.shots if shot.sensor == serial and not shot.dropped]
    host = np.array([shot.host_ns for shot in shots], dtype=np.int64)
    arrivals = arrival_times(host, tape.clock("frames"), tape.rng(10 + number))
    for index, (shot, log_ns) in enumerate(zip(shots, arrivals.tolist(), strict=True)):
        yield log_ns, number, index, partial(_image_message, tape, shot, progress)


def _image_message(tape: Tape, shot: Shot, progress: Callable[[int], None]) -> bytes:
    """Return the bytes of an image message, drawn and encoded now."""
    setup = tape.scenario.images
    picture = turned(shot.picture(), setup)
    frame = f"digit_{shot.sensor}"
    progress(1)
    if setup.encoding != "raw":
        payload = encoded(picture, setup.encoding, setup.quality)
        return ros2_messages.compressed_image(shot.stamp_ns, frame, setup.encoding, payload)
    stated = OTHER_ORDER[setup.channels] if setup.mislabelled else setup.channels
    height, width = picture.shape[:2]
    return ros2_messages.raw_image(shot.stamp_ns, frame, stated, height, width, raw_bytes(picture, setup.channels))


def _describe(tape: Tape, writer: Writer) -> None:
    """Write the description as a metadata record, and backgrounds and meshes as attachments of the names in it."""
    start = tape.scenario.start_ns
    for name, background in tape.backgrounds.items():
        writer.add_attachment(start, start, name, "image/png", encoded(background, "png", 0))
    for name, path in tape.files.items():
        writer.add_attachment(start, start, name, "model/stl", path.read_bytes())
    document = dict(tape.description)
    if tape.trajectories:
        document["trajectories"] = [dict(row) for row in tape.trajectories]
    writer.add_metadata("tactiledata", {"log": json_bytes(document).decode()})
