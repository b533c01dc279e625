"""Records that travel between the parts of the house: what a recording holds, and what becomes of it in a store.

A *format* reads a source into a `Recording` (as it was recorded, three time stamps a sample) and pushes its images
into an `ImageSink`. *Ingest* turns a `Recording` into a `Take` (checked, on one clock, cut into trajectories, aligned),
which the *store* keeps.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.contract.description import LogDescription
from tactiledata.units import signal_units

Times = NDArray[np.int64]
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
    """Where a format pushes images, in the order in which it meets them; nothing is kept in memory."""

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


@dataclass(frozen=True)
class StoredSignal:
    """A signal on the host clock, ready to be kept.

    Parameters
    ----------
    t_ns : (n,) int64
        Non-decreasing.
    values : (n, k) float64
    columns, units : (k,) names
    frame : str
    stamps : Stamps
        The stamps as recorded, in the order of ``t_ns``.
    attributes : dict
        Clock used, effective rate, how it was derived; JSON values.
    """

    t_ns: Times
    values: Values
    columns: tuple[str, ...]
    units: tuple[str, ...]
    frame: str
    stamps: Stamps
    attributes: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class AlignedSignal:
    """Values at the moments of the frames, derived.

    Parameters
    ----------
    values : (n_frames, k) float64
        NaN where there is no sample on both sides.
    gap_ns : (n_frames,) int64
        Distance between the two samples that the value lies between; -1 where there is none.
    columns, units : (k,) names
    frame, method : str
    """

    values: Values
    gap_ns: Times
    columns: tuple[str, ...]
    units: tuple[str, ...]
    frame: str
    method: str


@dataclass(frozen=True)
class Reference:
    """A picture of a sensor without contact.

    Parameters
    ----------
    image : (H, W, 3) uint8 RGB
    origin : str
        In words: a file, or how many frames were averaged.
    """

    image: NDArray[np.uint8]
    origin: str
    licence: str = ""
    model: str = ""


FRAME_SCHEMA = pa.schema(
    [
        ("trajectory", pa.int32()),  # row in the trajectories table, -1 outside any
        ("source", pa.int32()),  # row in the sources table
        ("camera", pa.dictionary(pa.int32(), pa.string())),
        ("sensor", pa.dictionary(pa.int32(), pa.string())),
        ("t_ns", pa.int64()),  # host clock
        ("log_ns", pa.int64()),
        ("publish_ns", pa.int64()),
        ("header_ns", pa.int64()),
        ("encoding", pa.dictionary(pa.int32(), pa.string())),
        ("height", pa.int16()),
        ("width", pa.int16()),
        ("offset", pa.int64()),  # first byte in the camera's heap, or row in its rgb array; -1 where missing
        ("length", pa.int64()),  # bytes in the heap, 0 for rgb
        ("crc32c", pa.uint32()),  # of the payload
        ("contact_force", pa.float32()),  # N, NaN where no wrench
        ("flags", pa.uint32()),  # bits of FrameFlag
        ("parent_frame", pa.int64()),  # row in the store that it was derived from, -1 for recorded frames
    ]
)
"""Columns of index/frames.parquet. The row number over all parts is the frame's number in every array."""

TRAJECTORY_SCHEMA = pa.schema(
    [
        ("uid", pa.string()),  # 16 hex digits: of the source's digest and the trajectory's name
        ("trajectory", pa.string()),
        ("source", pa.int32()),
        ("sensor", pa.string()),
        ("indenter", pa.string()),
        ("start_ns", pa.int64()),
        ("end_ns", pa.int64()),
        ("frame_start", pa.int64()),
        ("frame_stop", pa.int64()),
        ("signal_rows", pa.string()),  # JSON {signal: [start, stop]}
        ("peak_force", pa.float32()),  # N, NaN where no wrench
        ("segmented", pa.string()),  # "log" where the recording named it, else the method
        ("parent", pa.string()),  # uid that it was derived from, "" for recorded ones
        ("extra", pa.string()),  # JSON of the free columns
    ]
)
"""Columns of index/trajectories.parquet."""

SOURCE_SCHEMA = pa.schema(
    [
        ("sha256", pa.string()),
        ("key", pa.string()),
        ("format", pa.string()),
        ("frames", pa.int64()),
        ("trajectories", pa.int64()),
        ("status", pa.string()),  # "ok", "unverified", "damaged"
        ("description", pa.string()),  # JSON of the log description
        ("provenance", pa.string()),  # JSON
        ("contents", pa.string()),  # JSON: rows, CRC-32C and attributes of its signals and derived values; digest
    ]
)
"""Columns of index/sources.parquet."""

FINDING_SCHEMA = pa.schema(
    [
        ("source", pa.int32()),
        ("code", pa.string()),
        ("severity", pa.string()),
        ("message", pa.string()),
        ("stream", pa.string()),
        ("trajectory", pa.string()),
        ("start_ns", pa.int64()),
        ("end_ns", pa.int64()),
        ("count", pa.int64()),
    ]
)
"""Columns of index/findings.parquet."""


class FrameFlag:
    """Bits of the column ``flags``."""

    MISSING = 1  # no image was recorded
    BROKEN = 2  # the bytes do not decode; kept as they came
    GAP = 4  # an aligned value lies in a gap longer than allowed
    OUTSIDE = 8  # outside any trajectory


@dataclass(frozen=True)
class Take:
    """One source, checked and on one clock, ready for the store. Row numbers are local to the take.

    Parameters
    ----------
    source : Source
    sha256 : str
        Digest of the source's files.
    status : "ok", "unverified" or "damaged"
    description : dict
    provenance : dict
    frames : pa.Table
        ``FRAME_SCHEMA``; ``source`` is 0, ``trajectory`` a row of ``trajectories`` below; sorted so that the frames of
        a trajectory are contiguous; ``offset``/``length`` point into the camera's spool file.
    trajectories : pa.Table
        ``TRAJECTORY_SCHEMA``; ``frame_start``... and ``signal_rows`` are local to the take.
    findings : pa.Table
        ``FINDING_SCHEMA``
    signals : dict of StoredSignal
    aligned : dict of AlignedSignal
        Rows are those of ``frames``.
    frame_values : dict of FrameValues
        Rows are those of ``frames``.
    references : dict of Reference, by sensor
    sensors : dict, sensor -> facts
        Model, serial, licence, gel: what the sensors registry of the store keeps.
    """

    source: Source
    sha256: str
    status: str
    description: Mapping[str, Any]
    provenance: Mapping[str, Any]
    frames: pa.Table
    trajectories: pa.Table
    findings: pa.Table
    signals: Mapping[str, StoredSignal] = field(default_factory=dict)
    aligned: Mapping[str, AlignedSignal] = field(default_factory=dict)
    frame_values: Mapping[str, FrameValues] = field(default_factory=dict)
    references: Mapping[str, Reference] = field(default_factory=dict)
    sensors: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


def findings_table(findings: tuple[Finding, ...] | list[Finding]) -> pa.Table:
    """Findings as a table with ``FINDING_SCHEMA``, source 0."""
    return pa.table(
        {
            "source": pa.array([0] * len(findings), pa.int32()),
            "code": pa.array([finding.code for finding in findings], pa.string()),
            "severity": pa.array([finding.severity for finding in findings], pa.string()),
            "message": pa.array([finding.message for finding in findings], pa.string()),
            "stream": pa.array([finding.stream for finding in findings], pa.string()),
            "trajectory": pa.array([finding.trajectory for finding in findings], pa.string()),
            "start_ns": pa.array([finding.start_ns for finding in findings], pa.int64()),
            "end_ns": pa.array([finding.end_ns for finding in findings], pa.int64()),
            "count": pa.array([finding.count for finding in findings], pa.int64()),
        },
        schema=FINDING_SCHEMA,
    )


def findings_of(table: pa.Table) -> tuple[Finding, ...]:
    """The findings of a table with ``FINDING_SCHEMA``."""
    return tuple(
        Finding(**{name: row[name] for name in FINDING_SCHEMA.names if name != "source"}) for row in table.to_pylist()
    )
