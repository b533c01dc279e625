"""What the importers of public corpora share: walking folders, nominal clocks, sources and their inspection.

Shared by the family, as `base` is: members may import it.
"""

from __future__ import annotations

import re
from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, NoReturn

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.description import LOG_FORMAT, LogDescription
from tactiledata.contract.records import ImageSink, Recording, Signal, Source, Trajectory
from tactiledata.contract.simulated import Kind
from tactiledata.contract.wording import listed
from tactiledata.errors import BrokenLog, MissingFile, UsageError
from tactiledata.formats.base import Format, Inspection, NoSink, TopicInfo
from tactiledata.formats.reading.intake import Intake, Payload
from tactiledata.formats.reading.links import links_below
from tactiledata.formats.reading.natural_order import natural_key
from tactiledata.formats.reading.stream_info import camera_info, signal_info

SECOND = 10**9
"""Nanoseconds."""
NOMINAL_RATE = 30
"""Hz, where a corpus gives the order of its frames and no times: the rate that the DIGIT's driver defaults to."""
DEEP = 4
"""Levels below a source at which its files lie, at most."""
PAUSE_NS = SECOND
"""Put between the trajectories of a corpus without a clock, so that they do not touch."""


def nominal_ns(index: int) -> int:
    """The time of the frame with this index on a clock of `NOMINAL_RATE`, exact to the nanosecond below."""
    return index * SECOND // NOMINAL_RATE


def seconds_to_ns(seconds: Any) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Times (n,) in int64 ns of times in seconds, and which of them were numbers.

    What is not a finite number continues the clock before it at the nominal rate.
    """
    given = np.asarray(seconds, dtype=np.float64).reshape(-1)
    is_good = np.isfinite(given) & (np.abs(given) < 2**62 / SECOND)
    times = np.rint(np.where(is_good, given, 0.0) * SECOND).astype(np.int64)
    for row in np.flatnonzero(~is_good):
        times[row] = times[row - 1] + nominal_ns(1) if row else 0
    return times, is_good


def stream_name(text: str) -> str:
    """A name that the store takes for a stream, made from one that a corpus uses."""
    cleaned = re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")[:60]
    return cleaned if cleaned[:1].isalpha() else f"v_{cleaned}".rstrip("_")


def subfolders(root: Path, depth: int, skip: Callable[[str], bool] = lambda name: False) -> Iterator[Path]:
    """A folder and the folders below it, in natural order, at most ``depth`` levels deep; links are not followed.

    Parameters
    ----------
    root : Path
        The folder to begin with.
    depth : int
        Levels below it that are looked into.
    skip : callable
        Of a folder's name: whether it and what lies below it are left out; none is by default.
    """
    yield root
    if depth <= 0:
        return
    try:
        below = [path for path in root.iterdir() if path.is_dir() and not path.is_symlink() and not skip(path.name)]
    except OSError:
        return
    for path in sorted(below, key=lambda path: natural_key(path.name)):
        yield from subfolders(path, depth - 1, skip)


def files_in(folder: Path, suffixes: Sequence[str]) -> list[Path]:
    """The files of a folder with one of these endings (lower case), in natural order; links are left out."""
    if not folder.is_dir():
        return []
    found = [
        path
        for path in folder.iterdir()
        if path.suffix.lower() in suffixes and path.is_file() and not path.is_symlink()
    ]
    return sorted(found, key=lambda path: natural_key(path.name))


def key_of(root: Path, path: Path) -> str:
    """A readable key of a source: the folder that was named and the way from there."""
    below = path.relative_to(root).as_posix()
    named = root.resolve().name
    return named if below == "." else f"{named}/{below}"


def read_bytes(path: Path) -> Payload:
    """A payload that is read when it is needed."""
    return path.read_bytes


class Timeline:
    """A clock for corpora that give order only: trajectories one after another, a pause between them."""

    def __init__(self) -> None:
        self._start = 0
        self._end = 0

    def begin(self) -> int:
        """The first moment of the next trajectory."""
        self._start = self._end + PAUSE_NS if self._end else 0
        return self._start

    def at(self, index: int) -> int:
        """The time of a frame of the current trajectory."""
        moment = self._start + nominal_ns(index)
        self._end = max(self._end, moment + nominal_ns(1))
        return moment

    def interval(self) -> tuple[int, int]:
        """The current trajectory's half-open interval."""
        return self._start, max(self._end, self._start + 1)


def note_nominal_rate(intake: Intake, what: str) -> None:
    """The finding that times were made up."""
    intake.note(
        "nominal-rate",
        "info",
        f"{what} gives the order of frames and no times: they are put on a clock of {NOMINAL_RATE} Hz",
    )


def describe(
    source: Source,
    mapping: Mapping[str, Any] | None,
    sensors: Mapping[str, str],
    title: str,
    licence: str,
    kind: Kind = "not stated",
) -> LogDescription:
    """A description of a corpus' recording, with what a mapping document adds to it.

    Parameters
    ----------
    source : Source
    mapping : dict, optional
        A mapping document, whose ``description`` is laid over the rest.
    sensors : dict, name -> model
    title, licence : str
        Of the corpus.
    kind : "simulated", "real" or "not stated"
        What the corpus says of its contacts.
    """
    document = {
        "format": LOG_FORMAT,
        "title": title,
        "licence": licence,
        "sensors": {name: {"model": model} for name, model in sensors.items()},
        **({} if kind == "not stated" else {"recorded_by": {"contact": kind}}),
    }
    description = LogDescription.checked(document, source.key)
    added = (mapping or {}).get("description")
    return description.merged(added, f"mapping for {source.key}") if added else description


def sensor_for(camera: str, known: str, mapping: Mapping[str, Any] | None) -> str:
    """The sensor's serial: what a mapping says of the camera, else the name that the importer gives it.

    Parameters
    ----------
    camera : str
        The camera's name in the recording.
    known : str
        The serial that the importer gives.
    mapping : dict, optional
        A mapping document; its ``images`` may name the sensor of a camera.
    """
    stated = ((mapping or {}).get("images") or {}).get(camera, {}).get("sensor")
    return str(stated) if stated else known


def beside(sensor: str, camera: str) -> str:
    """What a camera that only accompanies a sensor is called: two cameras are never one sensor."""
    return f"{sensor}-{camera}"


def raise_empty(source: Source, expected: str) -> NoReturn:
    """The error for a source in which there is nothing to read."""
    raise BrokenLog(
        f"nothing to read in {source.path}", expected, "Check that the download is complete.", key=source.key
    )


class CorpusFormat(Format):
    """A format whose sources are walked once, to read them or to see what they hold."""

    says_links: ClassVar[bool] = True
    """Whether links below a source, which are not followed, are said here; else the format says so itself."""

    @abstractmethod
    def record(self, source: Source, intake: Intake, mapping: Mapping[str, Any] | None) -> Recording:
        """The recording, its images given to the intake.

        Parameters
        ----------
        source : Source
            A part of the corpus, as `sources` found it.
        intake : Intake
            Takes the images, in order, with their values and findings.
        mapping : dict, optional
            A mapping document; it may name the sensor and describe it.
        """

    def read(self, source: Source, sink: ImageSink, mapping: Mapping[str, Any] | None = None) -> Recording:
        """A recording, as `Format.read` says.

        Parameters
        ----------
        source : Source
            A part of the corpus, as `sources` found it.
        sink : ImageSink
            Takes the images, in order.
        mapping : dict, optional
            A mapping document; it may name the sensor and describe it.
        """
        return self.record(source, Intake(sink), mapping)

    def inspect(
        self, source: Source, mapping: Mapping[str, Any] | None = None, sink: ImageSink | None = None
    ) -> Inspection:
        """What the source holds; image files are counted, the first ones of each camera are opened.

        Parameters
        ----------
        source : Source
            One of `sources`.
        mapping : dict, optional
            A document that fits ``schemas/mapping.json``.
        sink : ImageSink, optional
            Takes the images in their order; those that were not opened come without bytes.
        """
        intake = Intake(NoSink() if sink is None else sink, is_looking=True)
        recording = self.record(source, intake, mapping)
        cameras = [camera_info(name, *facts) for name, facts in intake.cameras.items()]
        signals = [signal_info(signal) for signal in recording.signals.values()]
        values = [
            TopicInfo(name, "values of images", "", int(np.isfinite(kept.values).any(axis=1).sum()), note=kept.note)
            for name, kept in recording.frame_values.items()
        ]
        facts = {
            "trajectories": len(recording.trajectories),
            "sensors": sorted(recording.description.sensors),
            "indenters": sorted({touch.indenter for touch in recording.trajectories if touch.indenter}),
            "licence": self.licence_note,
            **({"pictures not opened": intake.not_opened()} if intake.not_opened() else {}),
        }
        return Inspection(source, (*cameras, *signals, *values), recording.findings, facts, recording=recording)

    def finish(
        self,
        source: Source,
        intake: Intake,
        description: LogDescription,
        trajectories: Sequence[Trajectory],
        signals: Mapping[str, Signal] | None = None,
        references: Mapping[str, tuple[NDArray[np.uint8], str]] | None = None,
    ) -> Recording:
        """The recording of what the intake took; ``references`` are pictures with their origin, by sensor.

        Parameters
        ----------
        source : Source
            What was read.
        intake : Intake
            Holds the findings and the values of images.
        description : LogDescription
            What is known of the recording beside its numbers.
        trajectories : sequence of Trajectory
            Its touches.
        signals : dict of Signal, optional
            Signals by name; none by default.
        references : dict, optional
            Pictures without contact (height, width, 3) uint8 with their origin, by sensor.
        """
        if self.says_links:
            _note_links(source, intake)
        pictures = references or {}
        return Recording(
            source,
            description,
            dict(signals or {}),
            tuple(trajectories),
            intake.findings,
            "log",
            {sensor: picture for sensor, (picture, _) in pictures.items()},
            {sensor: origin for sensor, (_, origin) in pictures.items()},
            intake.frame_values(),
        )

    def make_source(self, root: Path, home: Path, files: Sequence[Path], part: Path | None = None) -> Source:
        """A source of this format: ``root`` is what the user named, ``home`` holds all ``files``.

        Where ``home`` holds several sources, ``part`` is the file or folder inside it that this one is about.

        Parameters
        ----------
        root : Path
            What the user named.
        home : Path
            Holds all ``files``.
        files : sequence of Path
            Files that the source is read from.
        part : Path, optional
            The file or folder inside ``home`` that this source is about, where ``home`` holds several.
        """
        key = key_of(root, home if part is None else part)
        return Source(str(home), key, self.name, tuple(map(str, files)), "" if part is None else part.name)

    def require(self, path: Path) -> None:
        """Refuse a path that does not exist or is not of this format."""
        if not path.exists():
            raise MissingFile(f"{path} does not exist", f"a file or folder of {self.title}", path=str(path))
        if not self.sniff(path):
            raise UsageError(f"{path} is not of format {self.name}", self.layout.strip(), path=str(path))


def _note_links(source: Source, intake: Intake) -> None:
    """Say that links were not followed: in a copy whose content was not fetched they stand for images."""
    links = links_below(Path(source.path) / source.part, DEEP)
    if links:
        are = "is a link, which is" if len(links) == 1 else "are links, which are"
        text = f"{listed(links, 5)} {are} not followed; fetch or copy the files into the folder"
        intake.note("link-left", "warning", text, count=len(links))
