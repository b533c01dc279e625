"""The frames table of a recording: its images in the order of trajectories, times chosen, sensors known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.contract.records import Finding, Recording, Stamps, Times
from tactiledata.contract.take import FRAME_SCHEMA, FrameFlag
from tactiledata.ingest.clocks.timeline import image_times


@dataclass(frozen=True)
class CapturedFrames:
    """Images as they were captured, in the order of the sink, with host times and sensors.

    Parameters
    ----------
    images : pa.Table
        The spool's columns.
    t_ns : (n,) int64
    sensors : list of str
        Serial of each image's sensor; empty where the recording says none.
    clocks : dict, camera -> clock and shift
    findings : list of Finding
    """

    images: pa.Table
    t_ns: Times
    sensors: list[str]
    clocks: dict[str, dict[str, object]]
    findings: list[Finding]


def capture_times(recording: Recording, images: pa.Table) -> CapturedFrames:
    """Images with host times, camera by camera."""
    cameras = np.array(images["camera"].to_pylist(), dtype=object)
    t_ns = np.zeros(images.num_rows, dtype=np.int64)
    clocks: dict[str, dict[str, object]] = {}
    findings: list[Finding] = []
    for camera in sorted(set(cameras)):
        rows = np.flatnonzero(cameras == camera)
        t_ns[rows], clocks[camera], said = image_times(recording, camera, _stamps(images, rows))
        findings.extend(said)
    sensors = images["sensor"].to_pylist()
    stated = list(recording.description.sensors)
    if len(stated) == 1:
        sensors = [sensor or stated[0] for sensor in sensors]
    return CapturedFrames(images, t_ns, sensors, clocks, findings)


def times_by_camera(captured: CapturedFrames) -> dict[str, Times]:
    """Host times (ns) of the images of each camera."""
    return {camera: captured.t_ns[rows] for camera, rows in rows_by_camera(captured).items()}


def rows_by_camera(captured: CapturedFrames) -> dict[str, NDArray[np.int64]]:
    """Rows of the images of each camera, in the order of the recording."""
    cameras = np.array(captured.images["camera"].to_pylist(), dtype=object)
    return {camera: np.flatnonzero(cameras == camera) for camera in captured.clocks}


def _stamps(images: pa.Table, rows: NDArray[np.int64]) -> Stamps:
    def column(name: str) -> Times | None:
        values = images[name].to_numpy()[rows]
        return None if (values < 0).all() else values

    log = column("log_ns")
    return Stamps(np.zeros(len(rows), np.int64) if log is None else log, column("publish_ns"), column("header_ns"))


def frame_order(captured: CapturedFrames, trajectory: NDArray[np.int32]) -> NDArray[np.int64]:
    """Order of the frames in the store: by trajectory, those outside any last, then by time and camera."""
    last = np.where(trajectory < 0, np.iinfo(np.int32).max, trajectory)
    cameras = np.array(captured.images["camera"].to_pylist(), dtype=object).astype(str)
    return np.lexsort((cameras, captured.t_ns, last))


def frames_table(
    captured: CapturedFrames,
    order: NDArray[np.int64],
    trajectory: NDArray[np.int32],
    sensors: list[str],
    contact_force: NDArray[np.float32],
    flags: NDArray[np.uint32],
) -> pa.Table:
    """Return the table of frames in the store's order, with ``FRAME_SCHEMA``.

    Parameters
    ----------
    captured : CapturedFrames
        Images in the order in which they were captured.
    order : (n,) int64
        Row in ``captured`` of each frame of the store.
    trajectory : (n,) int32
        Row of each frame's trajectory, -1 for none; in the store's order, as are all that follow.
    sensors : list of n str
        Serial of each frame's sensor.
    contact_force : (n,) float32, N
        Contact force, NaN where it is not known.
    flags : (n,) uint32
        Bits of `FrameFlag`.
    """
    images = captured.images.take(pa.array(order))
    columns: dict[str, Any] = {
        "trajectory": trajectory,
        "source": np.zeros(len(order), np.int32),
        "camera": _dictionary(images["camera"].to_pylist()),
        "sensor": _dictionary(sensors),
        "t_ns": captured.t_ns[order],
        "encoding": _dictionary(images["encoding"].to_pylist()),
        "contact_force": contact_force,
        "flags": flags,
        "parent_frame": np.full(len(order), -1, np.int64),
    }
    for name in ("log_ns", "publish_ns", "header_ns", "height", "width", "offset", "length", "crc32c"):
        columns[name] = images[name].combine_chunks()
    arrays = [
        columns[field.name]
        if isinstance(columns[field.name], pa.Array)
        else pa.array(columns[field.name], type=field.type)
        for field in FRAME_SCHEMA
    ]
    arrays = [array.cast(field.type) for array, field in zip(arrays, FRAME_SCHEMA, strict=True)]
    return pa.Table.from_arrays(arrays, schema=FRAME_SCHEMA)


def _dictionary(values: list[str]) -> pa.Array:
    """Dictionary-encoded names, sorted, so that equal content gives equal bytes."""
    names = sorted(set(values))
    codes = {name: code for code, name in enumerate(names)}
    return pa.DictionaryArray.from_arrays(
        pa.array([codes[value] for value in values], pa.int32()), pa.array(names, pa.string())
    )


def frame_flags(
    encodings: list[str], trajectory: NDArray[np.int32], gaps: dict[str, Times], gap_limit_ns: int
) -> NDArray[np.uint32]:
    """Return the bits of `FrameFlag` (n,) of each frame: image missing, outside any trajectory, in a gap of a signal.

    Parameters
    ----------
    encodings : list of n str
        Encoding of each image; "missing" where there is none.
    trajectory : (n,) int32
        Row of each frame's trajectory, -1 for none.
    gaps : dict, signal -> (n,) int64 ns
        Distance of the two samples of a signal about each frame; -1 outside the signal.
    gap_limit_ns : int
        Largest distance, ns, that is not flagged.
    """
    flags = np.zeros(len(trajectory), np.uint32)
    flags[np.array([encoding == "missing" for encoding in encodings], dtype=bool)] |= FrameFlag.MISSING
    flags[trajectory < 0] |= FrameFlag.OUTSIDE
    for gap in gaps.values():
        flags[(gap > gap_limit_ns) | (gap < 0)] |= FrameFlag.GAP
    return flags
