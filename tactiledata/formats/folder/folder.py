"""The folder log: one folder, one recording, in files that people can read (docs/formats-folder.md)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from tactiledata.contract.description import LOG_FORMAT, LogDescription
from tactiledata.contract.records import ImageSink, Recording, Source
from tactiledata.contract.schema import read_document
from tactiledata.errors import BrokenLog, SchemaError
from tactiledata.formats.base import Inspection, NoSink
from tactiledata.formats.folder.files import DESCRIPTION, TABLES, LogFolder, is_folder_log
from tactiledata.formats.folder.frames import FrameReader, SizeWatch, mapped_cameras
from tactiledata.formats.folder.signals import read_signals
from tactiledata.formats.folder.trajectories import read_trajectories
from tactiledata.formats.reading.backgrounds import load_backgrounds, size_findings
from tactiledata.formats.reading.corpus import CorpusFormat, key_of
from tactiledata.formats.reading.intake import Intake
from tactiledata.formats.reading.natural_order import natural_key

NESTED = 2
"""Levels below a named folder in which logs are looked for: a folder of days with a folder of logs each."""


class FolderFormat(CorpusFormat):
    """The folder log: log.yaml and CSV tables, images as files.

    Rows that cannot be read are left out and counted in a finding; the order of times is left as recorded. A log whose
    log.yaml does not fit its schema, whose tables lack a column, or that names a file outside itself is refused whole.
    """

    name = "folder"
    says_links = False
    title = "folder log"
    layout = """
<log>/log.yaml          rig, sensors, indenters, frames, clocks
      trajectories.csv  trajectory, start_ns, end_ns, sensor, indenter, ...
      wrench.csv        t_ns, fx, fy, fz, tx, ty, tz
      tcp.csv           t_ns, x, y, z, qx, qy, qz, qw
      joints.csv        t_ns, q0, q1, q2, q3, q4, q5        (optional)
      frames.csv        t_ns, trajectory, file              (file may be empty)
      frames/*.png|jpg
"""

    def sniff(self, path: Path) -> bool:
        """Whether a folder is one log. A folder of logs is not claimed: other recordings may lie beside them."""
        return path.is_dir() and is_folder_log(path)

    def sources(self, path: Path) -> Sequence[Source]:
        """The log itself, or the logs in a folder of logs, at most two levels below."""
        if self.sniff(path):
            return [self._source(path, path)]
        logs = [self._source(path, log) for log in _logs_below(path, NESTED)]
        if not logs:
            raise BrokenLog(f"{path} holds no folder log", self.layout.strip(), "Name a folder that has a log.yaml.")
        return logs

    def read(self, source: Source, sink: ImageSink, mapping: Mapping[str, Any] | None = None) -> Recording:
        """A recording, as `Format.read` says; the sizes of backgrounds and images are compared.

        Parameters
        ----------
        source : Source
            A folder log, as `sources` found it.
        sink : ImageSink
            Takes the images, in order.
        mapping : dict, optional
            A mapping document; it names cameras and describes the log.
        """
        watch = SizeWatch(sink)
        return _with_sizes(self.record(source, Intake(watch), mapping), watch)

    def inspect(
        self, source: Source, mapping: Mapping[str, Any] | None = None, sink: ImageSink | None = None
    ) -> Inspection:
        """What the log holds, with what is said of the sizes of the images that were opened.

        Parameters
        ----------
        source : Source
            One of `sources`.
        mapping : dict, optional
            A document that fits ``schemas/mapping.json``.
        sink : ImageSink, optional
            Takes the images in their order; those that were not opened come without bytes.
        """
        watch = SizeWatch(NoSink() if sink is None else sink)
        inspection = super().inspect(source, mapping, watch)
        assert inspection.recording is not None
        recording = _with_sizes(inspection.recording, watch)
        return replace(inspection, findings=recording.findings, recording=recording)

    def record(self, source: Source, intake: Intake, mapping: Mapping[str, Any] | None) -> Recording:
        """The recording, its images given to the intake.

        Parameters
        ----------
        source : Source
            A folder log, as `sources` found it.
        intake : Intake
            Takes the images; it is read afterwards for values and findings.
        mapping : dict, optional
            A mapping document; it names cameras and describes the log.

        Raises
        ------
        BrokenLog
            The folder has a description and no table.
        """
        folder = LogFolder(Path(source.path))
        description = _description(folder, mapping or {})
        if not any(folder.table(table) for table in TABLES):
            raise BrokenLog(
                f"{source.path} has a {DESCRIPTION} and none of {', '.join(TABLES)}",
                self.layout.strip(),
                "Copy the tables beside the description.",
            )
        touches = read_trajectories(folder, description)
        streams = read_signals(folder, description)
        backgrounds = load_backgrounds(description, folder.path)
        frames = FrameReader(folder, description, touches, mapped_cameras(description, mapping or {}))
        tables = frames.push(intake)
        return Recording(
            source,
            description.without_units(),
            streams.signals,
            touches.trajectories,
            (*touches.findings, *streams.findings, *backgrounds.findings, *tables, *intake.findings),
            "log",
            backgrounds.references,
            backgrounds.origins,
        )

    def _source(self, named: Path, log: Path) -> Source:
        files = tuple(str(path) for path in LogFolder(log).belonging())
        return Source(str(log), key_of(named.absolute(), log.absolute()), self.name, files)


def _with_sizes(recording: Recording, watch: SizeWatch) -> Recording:
    """The recording with what is said of backgrounds whose size is not that of their sensor's images."""
    sizes = size_findings(recording.references, watch.sizes)
    return replace(recording, findings=(*recording.findings, *sizes))


def _description(folder: LogFolder, mapping: Mapping[str, Any]) -> LogDescription:
    """What log.yaml says, with what a mapping adds laid over it."""
    path = folder.path(DESCRIPTION, "the log")
    document = read_document(path)
    addition = mapping.get("description")
    if addition and isinstance(document, Mapping):
        return LogDescription(document, str(path)).merged(addition, f"{path} with the mapping")
    stated = document.get("format") if isinstance(document, Mapping) else None
    if isinstance(stated, str) and stated.startswith("tactiledata-log/") and stated != LOG_FORMAT:
        raise SchemaError(
            f"{path} is of format {stated}",
            f"{LOG_FORMAT}",
            "Install a newer tactiledata, or write the log in this version.",
            path="$.format",
        )
    return LogDescription.checked(document, str(path))


def _logs_below(path: Path, depth: int) -> Iterator[Path]:
    """Folder logs below a folder, in natural order; links and hidden folders are not followed."""
    if depth == 0 or not path.is_dir():
        return
    below = [child for child in path.iterdir() if child.is_dir() and not child.is_symlink()]
    for child in sorted(below, key=lambda child: natural_key(child.name)):
        if child.name.startswith(".") or child.suffix == ".zarr":
            continue
        if is_folder_log(child):
            yield child
        else:
            yield from _logs_below(child, depth - 1)
