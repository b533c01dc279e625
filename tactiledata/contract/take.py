"""What becomes of a recording on its way into a store: streams on one clock, tables with their columns, the take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.contract.records import Finding, FrameValues, Source, Stamps, Times, Values


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
    STRAY_SIZE = 16  # another size than nearly all images of its sensor in the recording; kept as it came
    BLANK = 32  # of one colour throughout, such as black; kept as it came


UNUSABLE = FrameFlag.MISSING | FrameFlag.BROKEN | FrameFlag.STRAY_SIZE | FrameFlag.BLANK
"""Bits of frames that nothing learns from or compares with: no image, one that does not decode, one of another size, or
of one colour."""


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
