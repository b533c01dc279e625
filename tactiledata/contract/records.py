"""Records that travel between the parts of the house: what a recording holds, and what becomes of it in a store.

A *format* reads a source into a `Recording` (as it was recorded, three time stamps a sample) and pushes its images
into an `ImageSink`. *Ingest* turns a `Recording` into a `Take` (checked, on one clock, cut into trajectories, aligned),
which the *store* keeps.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Times
from tactiledata.contract.description import LogDescription
from tactiledata.units import signal_units

Values = NDArray[np.float64]
Severity = Literal["info", "warning", "damage"]
Encoding = Literal["jpeg", "png", "raw", "missing"]


@dataclass(frozen=True)
class Finding:
    """Something that the reader of a recording ought to know.

    Parameters
    ----------
    code : str
        Stable name of the kind, for example ``"chunk-crc"``; listed in docs/findings.md.
    severity : "info", "warning" or "damage"
        ``damage``: data were lost or cannot be trusted; commands then exit with 1, ``--strict`` refuses.
    message : str
        What was found, for people, with values and units.
    stream, trajectory : str
        Where; empty where it concerns the whole recording.
    start_ns, end_ns : int, optional
        The span of the host clock that it concerns.
    count : int
        How many samples, frames or records it concerns.
    """

    code: str
    severity: Severity
    message: str
    stream: str = ""
    trajectory: str = ""
    start_ns: int | None = None
    end_ns: int | None = None
    count: int = 1


@dataclass(frozen=True)
class Stamps:
    """The time stamps of n samples, each (n,) int64 ns; ``None`` where the recording has no such stamp.

    ``log`` is when the recorder wrote the message, ``publish`` when the sender sent it, ``header`` what the message
    itself says. A header stamp of 0 means "not set".
    """

    log: Times
    publish: Times | None = None
    header: Times | None = None

    def __len__(self) -> int:
        return len(self.log)

    def take(self, rows: NDArray[Any]) -> Stamps:
        """The stamps of some of the samples, by index or mask."""
        return Stamps(
            self.log[rows],
            None if self.publish is None else self.publish[rows],
            None if self.header is None else self.header[rows],
        )


@dataclass(frozen=True)
class Signal:
    """A stream of numbers at its native rate, as recorded.

    Parameters
    ----------
    name : str
        ``wrench``, ``tcp``, ``joints`` (columns and units as in ``units.SIGNAL_COLUMNS``) or a name of a mapping.
    stamps : Stamps
        (n,) time stamps.
    values : (n, k) float64
        SI units.
    columns : (k,) names
    frame : str
        The frame in which vectors are expressed, as the recording names it; empty where it says none.
    units : (k,) names, optional
        Taken from the units table where not given.
    """

    name: str
    stamps: Stamps
    values: Values
    columns: tuple[str, ...]
    frame: str = ""
    units: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.units:
            object.__setattr__(self, "units", signal_units(self.columns))
        assert self.values.shape == (len(self.stamps), len(self.columns)), self.values.shape


@dataclass(frozen=True)
class Trajectory:
    """One touch or free motion: the half-open interval [start_ns, end_ns) of the host clock.

    ``extra`` holds the free columns of trajectories.csv (numbers stay numbers).
    """

    name: str
    start_ns: int
    end_ns: int
    sensor: str = ""
    indenter: str = ""
    extra: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Image:
    """One captured image on its way into a store.

    Parameters
    ----------
    camera : str
        The stream under which the store keeps it, for example ``"digit"``.
    payload : bytes
        JPEG or PNG bytes as they came, or for ``raw`` height * width * 3 bytes of RGB, row-major.
    encoding : "jpeg", "png", "raw" or "missing"
        ``missing``: a captured moment without an image; ``payload`` is empty.
    height, width : int
        Pixels, of the picture as decoded.
    log_ns, publish_ns, header_ns : int
        The three time stamps; -1 where the recording has no such stamp.
    sensor : str
        Serial of the sensor, where the recording says so.
    trajectory : str
        Name of the trajectory, where the recording names one per image.
    name : str
        File name or topic, for messages.
    """

    camera: str
    payload: bytes
    encoding: Encoding
    height: int
    width: int
    log_ns: int
    publish_ns: int = -1
    header_ns: int = -1
    sensor: str = ""
    trajectory: str = ""
    name: str = ""


class ImageSink(Protocol):
    """A receiver to which a format pushes images in the order in which it meets them; it keeps nothing in memory."""

    def add(self, image: Image) -> None:
        """Take one image."""
        ...


@dataclass(frozen=True)
class Source:
    """One recording: what one ingest task reads, and what is either wholly in a store or not at all.

    Parameters
    ----------
    path : str
        File or folder.
    key : str
        A name that is unique in the call and readable, for example ``"day1/run3.mcap"``.
    format : str
        Name in the table of formats.
    files : tuple of str
        All files that belong to it; their contents are its identity (SHA-256).
    part : str
        Which part, where one file or folder holds several recordings.
    """

    path: str
    key: str
    format: str
    files: tuple[str, ...]
    part: str = ""

    def absolute(self) -> Source:
        """Give the same recording by absolute paths, as a process that was started in another folder needs them."""
        files = tuple(str(Path(name).absolute()) for name in self.files)
        return replace(self, path=str(Path(self.path).absolute()), files=files)


@dataclass(frozen=True)
class Recording:
    """A source as recorded; its images went into the sink.

    Parameters
    ----------
    source : Source
    description : LogDescription
        What the recording says of itself; an empty one where it says nothing.
    signals : dict of Signal, by name
    trajectories : tuple of Trajectory
        Empty where the recording names none: ingest then finds contacts itself.
    findings : tuple of Finding
        What the reader met, damage included.
    host_clock : "log", "publish", "header" or "auto"
        Which stamp is the host clock. Formats with one clock put it into ``Stamps.log`` and say ``"log"``.
    references : dict, sensor -> (H, W, 3) uint8 RGB
        Images without contact that the recording holds.
    reference_sources : dict, sensor -> str
        Where each of them came from, in words.
    frame_values : dict of FrameValues, by name
        Values that belong to images one by one rather than to a clock (annotated contact centres, forces of a corpus):
        rows in the order in which images went into the sink.
    """

    source: Source
    description: LogDescription
    signals: Mapping[str, Signal] = field(default_factory=dict)
    trajectories: tuple[Trajectory, ...] = ()
    findings: tuple[Finding, ...] = ()
    host_clock: Literal["log", "publish", "header", "auto"] = "log"
    references: Mapping[str, NDArray[np.uint8]] = field(default_factory=dict)
    reference_sources: Mapping[str, str] = field(default_factory=dict)
    frame_values: Mapping[str, FrameValues] = field(default_factory=dict)


@dataclass(frozen=True)
class FrameValues:
    """Values that belong to images one by one: (n_images, k), NaN where an image has none."""

    values: Values
    columns: tuple[str, ...]
    units: tuple[str, ...]
    note: str = ""
