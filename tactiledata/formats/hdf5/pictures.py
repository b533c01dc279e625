"""Mapped cameras of an HDF5 file: arrays of pixels, or of JPEG and PNG files, frame by frame in the order of time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Times
from tactiledata.errors import BrokenLog
from tactiledata.formats.hdf5.signals import ArrayFile
from tactiledata.formats.reading.described import camera_topics
from tactiledata.formats.reading.hdf5_members import Hdf5Rows, UnreadableNumbers
from tactiledata.formats.reading.intake import Intake


@dataclass(frozen=True)
class ArrayCamera:
    """A camera whose pictures are in a file.

    Parameters
    ----------
    name : str
        Under which the store keeps it.
    topic : str
        Path of its pictures.
    sensor : str
        Serial; empty where the mapping names none.
    is_bgr : bool
        Whether pixels come in OpenCV's order.
    rows : Hdf5Rows
        Its pictures.
    times : (n,) ns
    is_time : (n,) bool
        Which of them are times.
    """

    name: str
    topic: str
    sensor: str
    is_bgr: bool
    rows: Hdf5Rows
    times: Times
    is_time: NDArray[np.bool_]

    def payload(self, number: int) -> bytes | NDArray[np.uint8]:
        """Return the bytes of a picture file, or pixels (height, width, 3), RGB."""
        found = self.rows.row(number)
        if self.rows.is_packed:
            return found.tobytes()
        return np.ascontiguousarray(found[..., ::-1]) if self.is_bgr else found


def mapped_cameras(file: ArrayFile, mapping: Mapping[str, Any], intake: Intake) -> list[ArrayCamera]:
    """Return the cameras of a mapping whose pictures are in a file.

    Parameters
    ----------
    file : ArrayFile
    mapping : dict
        A document that fits ``schemas/mapping.json``.
    intake : Intake
        Takes findings.

    Raises
    ------
    BrokenLog
        An array is there and holds no pictures, or its times do not fit.
    """
    cameras = []
    for name, entry in mapping.get("images", {}).items():
        place, topics = f"images.{name}", camera_topics(entry)
        topic = next((path for path in topics if file.has(path)), "")
        if not topic:
            text = (
                f"{file.name} has no {' or '.join(topics)}, which the mapping names under {place}; {name} is not read"
            )
            intake.note("missing-topic", "warning", text, name)
            continue
        rows = _rows(file, topic, place)
        times, is_time = file.times(entry, place, len(rows))
        is_bgr = entry.get("channel_order") == "bgr"
        cameras.append(ArrayCamera(name, topic, str(entry.get("sensor", "")), is_bgr, rows, times, is_time))
    return cameras


def push_pictures(cameras: list[ArrayCamera], intake: Intake) -> None:
    """Give all pictures to the intake, in the order of their times; of equal times, in that of the cameras.

    Parameters
    ----------
    cameras : list of ArrayCamera
    intake : Intake
        Takes the pictures, and a finding for those without a time.
    """
    order = []
    for place, camera in enumerate(cameras):
        numbers = np.flatnonzero(camera.is_time)
        order.append(np.column_stack([camera.times[numbers], np.full(len(numbers), place), numbers]))
        lost = len(camera.times) - len(numbers)
        if lost:
            text = f"{lost} pictures of {camera.topic} have no time that is a number; left out"
            intake.note("bad-stamp", "damage", text, camera.name, count=lost)
    rows = np.concatenate(order) if order else np.zeros((0, 3), dtype=np.int64)
    for t_ns, place, number in rows[np.lexsort((rows[:, 2], rows[:, 1], rows[:, 0]))].tolist():
        camera = cameras[place]
        payload = partial(camera.payload, number)
        intake.image(camera.name, payload, t_ns, sensor=camera.sensor, name=f"{camera.topic}[{number}]")


def _rows(file: ArrayFile, topic: str, place: str) -> Hdf5Rows:
    """Return an array of pictures."""
    expected = "(n, height, width, 3) uint8, or n JPEG or PNG files as bytes of varying length"
    try:
        rows = file.members.rows(*file.parent(topic))
    except UnreadableNumbers as error:
        raise BrokenLog(
            f"{file.name}: {topic} holds no pictures that are read: it is {error}", expected,
            f"The mapping names it under {place}.", file=file.name,
        ) from error  # fmt: skip
    if rows is None or not (rows.is_packed or (len(rows.shape) == 4 and rows.shape[3] == 3)):
        found = "a group" if rows is None else f"of shape {rows.shape}"
        raise BrokenLog(
            f"{file.name}: {topic} holds no pictures: it is {found}", expected,
            f"The mapping names it under {place}.", file=file.name,
        )  # fmt: skip
    return rows
