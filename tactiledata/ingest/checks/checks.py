"""What can be said of a recording's images and forces before they are kept: nothing is silently wrong."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.contract.description import LogDescription
from tactiledata.contract.image_sizes import Size
from tactiledata.contract.records import Finding
from tactiledata.contract.take import UNUSABLE, Take
from tactiledata.contract.wording import agreeing, counted, listed
from tactiledata.ingest.checks.apart import apart_findings
from tactiledata.ingest.checks.background_seen import channel_findings, touched_findings
from tactiledata.ingest.checks.image_sizes import size_counts
from tactiledata.ingest.checks.plausible import clock_findings, description_findings, mesh_findings
from tactiledata.ingest.checks.spooled import SpooledImages
from tactiledata.ingest.checks.units_seen import unit_findings
from tactiledata.sensors import SENSORS
from tactiledata.sensors.base import Sensor
from tactiledata.sensors.image_checks import size_orientation

TRAILERS = {"jpeg": b"\xff\xd9", "png": b"IEND"}
"""What a whole file of an encoding ends with (ITU T.81 B.1.1.3: end of image; PNG 11.2.5: the IEND chunk)."""

TRAILER_BYTES = 64
"""Some encoders pad after the trailer; it is looked for in this many bytes at the end."""

MOST_SIZES = 3
"""Sizes of one sensor's images of which something is said."""

FT_RANGE = 300.0
"""N. The Robotiq FT 300-S measures up to this; more is a fault, not a force."""

TORQUE_RANGE = 30.0
"""N m, likewise. An offset beyond it leaves nothing of the sensor's range, although it is taken off as a zero."""

Decode = Callable[[NDArray[np.int64]], list[NDArray[np.uint8] | None]]


def broken_images(images: SpooledImages) -> tuple[NDArray[np.int64], list[Finding]]:
    """Rows (in the order of the sink) of images that end too early, and findings.

    Every encoded image is looked at, by its last bytes only: decoding all would take longer than reading the recording.
    `tactiledata check --decode` decodes all.
    """
    encodings = images.columns["encoding"].to_pylist()
    broken: list[int] = []
    for encoding in TRAILERS:
        rows = [row for row, name in enumerate(encodings) if name == encoding]
        tails = images.tails(rows, TRAILER_BYTES)
        broken.extend(row for row, tail in zip(rows, tails, strict=True) if ends_early(encoding, tail))
    return np.array(sorted(broken), np.int64), [broken_finding(len(broken))] if broken else []


def ends_early(encoding: str, content: bytes) -> bool:
    """Whether an encoded image, or its last bytes, lack the mark that a whole file of its encoding ends with."""
    return encoding in TRAILERS and TRAILERS[encoding] not in content[-TRAILER_BYTES:]


def broken_finding(count: int) -> Finding:
    """What is said of this many images that end too early."""
    end = agreeing(count, "ends", "end")
    text = f"{counted(count, 'image')} {end} too early; what came is kept, and training leaves it out"
    return Finding("image-truncated", "damage", text, count=count)


def flag_images(frames: pa.Table, order: NDArray[np.int64], rows: NDArray[np.int64], flag: int) -> pa.Table:
    """The frames table with a flag set for some images.

    Parameters
    ----------
    frames : pa.Table
        ``FRAME_SCHEMA``, n rows.
    order : (n,)
        Row in the sink of each frame.
    rows : (k,)
        Rows in the sink.
    flag : int
        One of `FrameFlag`.
    """
    if not len(rows):
        return frames
    flags = frames["flags"].to_numpy().copy()
    flags[np.isin(order, rows)] |= flag
    return frames.set_column(frames.schema.get_field_index("flags"), frames.schema.field("flags"), pa.array(flags))


def check_take(take: Take, decode: Decode) -> list[Finding]:
    """Findings on what is stated, units, image sizes, channel order, stuck cameras, forces and empty trajectories.

    Parameters
    ----------
    take : Take
    decode : callable
        Images of rows of ``take.frames``.
    """
    description = LogDescription(take.description)
    return [
        *description_findings(description),
        *clock_findings(description, take.signals),
        *mesh_findings(description, Path(take.source.path)),
        *unit_findings(take),
        *_picture_findings(take, decode),
        *_stuck_camera(take),
        *_force_findings(take),
        *_empty_trajectories(take),
        *apart_findings(take),
    ]


def _picture_findings(take: Take, decode: Decode) -> list[Finding]:
    """Size and channel order of each sensor's first, middle and last image against what the sensor gives."""
    found: list[Finding] = []
    names = np.array(take.frames["sensor"].to_pylist(), dtype=object)
    usable = (take.frames["flags"].to_numpy() & UNUSABLE) == 0
    sizes = size_counts(take.frames)
    for sensor in sorted(set(names)):
        rows = np.flatnonzero((names == sensor) & usable)
        if not len(rows):
            continue
        chosen = rows[[0, len(rows) // 2, -1]]
        images = [image for image in decode(chosen) if image is not None]
        model = take.sensors.get(sensor, {}).get("model", "digit")
        known = SENSORS.get(model)
        if known is not None and known.camera is not None and images:
            found.extend(_size_findings(sensor, sizes[sensor], known, known.camera.shape))
        swapped = channel_findings(sensor, images, take, model)
        # pictures whose channels are swapped differ everywhere
        found.extend(swapped or touched_findings(sensor, take, decode))
    return found


def stated_size_findings(take: Take) -> list[Finding]:
    """Findings on the sizes that the heads of images state, for a take whose images were not decoded."""
    found: list[Finding] = []
    for sensor, counts in sorted(size_counts(take.frames).items()):
        known = SENSORS.get(take.sensors.get(sensor, {}).get("model", "digit"))
        if known is not None and known.camera is not None:
            found.extend(_size_findings(sensor, counts, known, known.camera.shape))
    return found


def _size_findings(sensor: str, counts: Counter[Size], known: Sensor, shape: tuple[int, int]) -> list[Finding]:
    """What is said of the sizes that a sensor's images have, where they are not the sensor model's."""
    found, total = [], sum(counts.values())
    for size, count in counts.most_common(MOST_SIZES):
        verdict = size_orientation(size, known)
        if verdict == "ok":
            continue
        which = "images" if count == total else f"{count} of {total} images"
        text = f"{which} of {sensor!r} have {size[0]} rows x {size[1]} columns; a {known.name} gives "
        if verdict == "swapped":
            text += f"{shape[0]} x {shape[1]}: height and width swapped"
            found.append(Finding("image-swapped", "warning", text))
        else:
            found.append(Finding("image-size", "info", f"{text}{shape[0]} rows x {shape[1]} columns"))
    return found


def _stuck_camera(take: Take) -> list[Finding]:
    """Images that repeat the one before, bit for bit, while the force moves on."""
    trajectory = take.frames["trajectory"].to_numpy()
    crc = take.frames["crc32c"].to_numpy()
    force = take.frames["contact_force"].to_numpy()
    length = take.frames["length"].to_numpy()
    if len(crc) < 2:
        return []
    same = (crc[1:] == crc[:-1]) & (length[1:] == length[:-1]) & (length[1:] > 0) & (trajectory[1:] == trajectory[:-1])
    # a slow press changes little from image to image: the force is judged over all repeats of one image
    starts = np.flatnonzero(np.concatenate([[True], ~same]))
    stuck = np.fmax.reduceat(force, starts) - np.fmin.reduceat(force, starts) > 1.0
    repeats = int((np.diff([*starts, len(crc)]) - 1)[stuck].sum())
    if not repeats:
        return []
    again = f"{counted(repeats, 'image')} {agreeing(repeats, 'repeats', 'repeat')}"
    text = f"{again} the one before bit for bit while the force changes by more than 1 N"
    return [Finding("camera-stuck", "warning", text, count=repeats)]


def _force_findings(take: Take) -> list[Finding]:
    wrench = take.signals.get("wrench")
    if wrench is None:
        return []
    found = []
    for code, columns, limit, unit in (
        ("force-out-of-range", slice(0, 3), FT_RANGE, "N"),
        ("torque-out-of-range", slice(3, 6), TORQUE_RANGE, "N m"),
    ):
        beyond = int((np.abs(wrench.values[:, columns]) > limit).any(axis=1).sum())
        if beyond:
            are = f"{counted(beyond, 'sample')} {agreeing(beyond, 'is', 'are')}"
            text = (
                f"wrench: {are} beyond {limit:.0f} {unit}, the range of a Robotiq FT 300-S; another "
                "unit, an offset that nobody zeroed, or a fault of the sensor"
            )
            found.append(Finding(code, "warning", text, "wrench", count=beyond))
    return found


def _empty_trajectories(take: Take) -> list[Finding]:
    start, stop = take.trajectories["frame_start"].to_numpy(), take.trajectories["frame_stop"].to_numpy()
    empty = np.flatnonzero(start == stop)
    if not len(empty) or take.frames.num_rows == 0:
        return []
    names = [take.trajectories["trajectory"][int(row)].as_py() for row in empty]
    hold = f"{counted(len(empty), 'trajectory')} {agreeing(len(empty), 'holds', 'hold')}"
    text = f"{hold} no image ({listed(names, 5)})"
    return [Finding("trajectory-without-frames", "info", text, count=len(empty))]
