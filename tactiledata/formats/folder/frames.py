"""frames.csv and the images that it names, pushed one by one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tactiledata.contract.description import LogDescription
from tactiledata.contract.image_sizes import Size
from tactiledata.contract.records import Finding, Image, ImageSink, Trajectory
from tactiledata.formats.folder.files import LogFolder
from tactiledata.formats.folder.signals import TIME, ignored_columns, open_table
from tactiledata.formats.folder.trajectories import TouchTable
from tactiledata.formats.reading.backgrounds import read_image_file
from tactiledata.formats.reading.corpus import stream_name
from tactiledata.formats.reading.csv_cells import listed, shortened
from tactiledata.formats.reading.intake import Intake, Payload

TABLE = "frames.csv"
COLUMNS = (TIME, "trajectory", "file")
ANY_CAMERA = "tactile"
"""Stream name of images whose sensor's model is not known."""


class SizeWatch:
    """A sink that counts the sizes of each sensor's images, and passes the images on."""

    def __init__(self, sink: ImageSink) -> None:
        self._sink = sink
        self.sizes: dict[str, Counter[Size]] = {}

    def add(self, image: Image) -> None:
        """Take one image."""
        if image.encoding != "missing":
            self.sizes.setdefault(image.sensor, Counter())[image.height, image.width] += 1
        self._sink.add(image)


@dataclass
class FrameReader:
    """Pushes the captured moments of a log, in the order of the table.

    Parameters
    ----------
    folder : LogFolder
    description : LogDescription
    touches : TouchTable
    cameras : dict
        Sensor -> stream name, from a mapping; the sensor's model otherwise.
    """

    folder: LogFolder
    description: LogDescription
    touches: TouchTable
    cameras: Mapping[str, str] = field(default_factory=dict)
    _named: dict[str, str] = field(default_factory=dict)

    def push(self, intake: Intake) -> list[Finding]:
        """Findings about the table; what is said about single images goes into the intake.

        Raises
        ------
        BrokenLog
            The table lacks a column or is no table of ours.
        UnsafeContent
            It names a file outside the log.
        """
        table, said = open_table(self.folder, TABLE, "frames")
        if table is None:
            return [*said, *([] if said else self._absence())]
        table.require((TIME, "file"), f"The table has the columns {listed(COLUMNS)}; docs/formats-folder.md shows one.")
        t_ns, has_time = table.nanoseconds(TIME)
        findings = [*said, *ignored_columns(table, COLUMNS, "frames")]
        findings += table.row_finding(
            "csv-time", ~has_time, f"have no {TIME} that is a whole number below 2^63; left out", "frames"
        )
        files = table.text("file")
        names = table.text("trajectory") if "trajectory" in table.columns else [""] * len(table)
        for row in np.flatnonzero(has_time):
            self._frame(intake, int(t_ns[row]), names[row], files[row])
        unlisted = self.folder.unlisted_pictures(set(files))
        if unlisted:
            message = f"{TABLE} does not name {len(unlisted)} images that are there: {listed(unlisted[:3])}; not read"
            findings.append(Finding("frame-file-unlisted", "warning", message, "frames", count=len(unlisted)))
        return findings

    def _absence(self) -> list[Finding]:
        there = self.folder.unlisted_pictures(set())
        if not there:
            return [Finding("stream-absent", "info", f"there is no {TABLE}", "frames")]
        message = f"{TABLE} is not there, so {len(there)} images in frames/ have no time; not read"
        return [Finding("stream-missing", "damage", message, "frames", count=len(there))]

    def _frame(self, intake: Intake, t_ns: int, name: str, file: str) -> None:
        touch = self._touch(intake, t_ns, name, file)
        sensor = touch.sensor if touch is not None else self._only_sensor()
        intake.image(
            self._camera(sensor),
            self._payload(intake, file),
            t_ns,
            sensor=sensor,
            trajectory="" if touch is None else touch.name,
            name=file or TABLE,
        )

    def _touch(self, intake: Intake, t_ns: int, name: str, file: str) -> Trajectory | None:
        host_ns = t_ns + self.description.clock_offset("frames")
        what = shortened(file or f"the moment {t_ns}", 60)
        if not name:
            touch = self.touches.at(host_ns)
            if touch is None and self.touches.trajectories:
                message = f"{TABLE}: {what} lies outside every trajectory"
                intake.note("frame-outside-trajectories", "warning", message, "frames")
            return touch
        touch = self.touches.named(name, host_ns)
        if touch is None:
            message = f"{TABLE}: {what} belongs to trajectory {shortened(name, 60)!r}, which no row names"
            intake.note("frame-trajectory-unknown", "damage", message, "frames")
        elif not touch.start_ns <= host_ns < touch.end_ns:
            message = f"{TABLE}: {what} lies outside its trajectory {shortened(name, 60)!r}"
            intake.note("frame-outside-trajectory", "warning", message, "frames")
        return touch

    def _payload(self, intake: Intake, file: str) -> Payload | None:
        if not file:
            return None
        path = self.folder.path(file, TABLE)
        try:
            is_there = path.exists()
        except OSError:  # a name longer than the file system has
            is_there = False
        if not is_there:
            message = f"{TABLE} names {shortened(file, 60)}, which is not there"
            intake.note("image-missing", "damage", message, "frames")
            return None
        return _reader(path)

    def _only_sensor(self) -> str:
        sensors = list(self.description.sensors)
        return sensors[0] if len(sensors) == 1 else ""

    def _camera(self, sensor: str) -> str:
        if sensor not in self._named:
            models = {facts.get("model", "") for facts in self.description.sensors.values()}
            known = self.description.sensors.get(sensor, {}).get("model", models.pop() if len(models) == 1 else "")
            self._named[sensor] = self.cameras.get(sensor) or (stream_name(str(known)) if known else ANY_CAMERA)
        return self._named[sensor]


def mapped_cameras(description: LogDescription, mapping: Mapping[str, Any]) -> dict[str, str]:
    """Sensor -> stream name, as a mapping states it: per sensor, or for all of them where it names none."""
    cameras: dict[str, str] = {}
    for camera, facts in mapping.get("images", {}).items():
        sensors = [facts["sensor"]] if "sensor" in facts else list(description.sensors)
        cameras.update(dict.fromkeys(sensors, camera))
    return cameras


def _reader(path: Path) -> Payload:
    return lambda: read_image_file(path)
