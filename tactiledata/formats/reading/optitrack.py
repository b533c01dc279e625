"""Poses tracked by OptiTrack: its CSV export (seven header rows), jumps, from the tracked DIGIT to the contact.

Shared by the family, as `base` is: members may import it.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import BrokenLog
from tactiledata.transforms import matrix_poses, pose_matrices

HEADER_ROWS = 7
START_LABEL = "Capture Start Time"
FAR = 1e6
"""Metres: beyond it a position is damage."""
CAMERA_TO_GEL = 0.022
"""Metres along the DIGIT's z axis from its tracked frame back to the gel; YCB-Slide's own scripts use it."""
JUMP_FACTOR = 10.0
"""A step that is longer than this many times the mean of the steps so far is a jump; YCB-Slide's criterion."""


@dataclass(frozen=True)
class Tracks:
    """Poses of rigid bodies at the tracker's own rate.

    Parameters
    ----------
    start : str
        Capture start time as the file states it (local time of the tracker's computer); empty where it says none.
    seconds : (n,) float64
        From the start of the capture.
    poses : dict, body -> (n, 7) float64
        Position, metres, and quaternion x y z w; NaN where the tracker lost the body (empty cells).
    """

    start: str
    seconds: NDArray[np.float64]
    poses: dict[str, NDArray[np.float64]]


def read_tracks(path: Path, bodies: Sequence[str]) -> Tracks:
    """The named bodies' poses.

    Raises
    ------
    BrokenLog
        Not such an export, or a body is not in it.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            rows = csv.reader(stream)
            header = [next(rows) for _ in range(HEADER_ROWS)]
            columns = {body: _body_columns(header, body, path) for body in bodies}
            table = [[_number(row, 1), *(_number(row, at) for body in bodies for at in columns[body])] for row in rows]
    except (StopIteration, UnicodeDecodeError, csv.Error) as error:
        raise _broken(path, f"{type(error).__name__} in the export") from error
    values = np.array(table, dtype=np.float64).reshape(-1, 1 + 7 * len(bodies))
    values = values[np.isfinite(values[:, 0])]
    poses = {}
    for index, body in enumerate(bodies):
        rotation_first = values[:, 1 + 7 * index : 8 + 7 * index]
        poses[body] = np.concatenate([rotation_first[:, 4:], rotation_first[:, :4]], axis=1)
    return Tracks(_start(header[0]), values[:, 0], poses)


def nearest_rows(times: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.intp]:
    """The row of ``times`` (n,), increasing, that is nearest to each of ``at`` (m,)."""
    after = np.clip(np.searchsorted(times, at), 1, max(len(times) - 1, 1))
    if len(times) == 1:
        return np.zeros(len(at), dtype=np.intp)
    return np.where(at - times[after - 1] <= times[after] - at, after - 1, after)


def contact_poses(
    digit: NDArray[np.float64], thing: NDArray[np.float64], alignment: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Poses (n, 7) of the contact in the object's frame, and which rows are jumps of the tracker (n,).

    The object's inverse times the DIGIT's pose, then 22 mm back along the DIGIT's z axis to the gel; ``alignment``
    (4, 4) corrects the translation only, as YCB-Slide does: its translation is added, its rotation does not act.
    Rows without both poses, and jumps, are NaN; no row is dropped.

    Parameters
    ----------
    digit, thing : (n, 7)
        Poses of the DIGIT and of the object in the tracker's frame, m and quaternions as `is_pose` takes them.
    alignment : (4, 4)
        The correction of YCB-Slide for this object, m.
    """
    poses = np.full((len(digit), 7), np.nan)
    is_whole = is_pose(digit) & is_pose(thing)
    rows = np.flatnonzero(is_whole)
    is_jump = np.zeros(len(digit), dtype=bool)
    if not len(rows):
        return poses, is_jump
    object_from_digit = np.linalg.inv(pose_matrices(thing[rows])) @ pose_matrices(digit[rows])
    is_jump[rows] = find_jumps(object_from_digit[:, :3, 3])
    digit_from_gel = np.eye(4)
    digit_from_gel[2, 3] = -CAMERA_TO_GEL
    object_from_gel = object_from_digit @ digit_from_gel
    object_from_gel[:, :3, 3] += alignment[:3, 3]
    poses[rows] = matrix_poses(object_from_gel)
    poses[is_jump] = np.nan
    return poses, is_jump


def find_jumps(positions: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return a mask (n,) of positions that lie farther from the one before than ten times the mean step so far.

    YCB-Slide's own filter; its script deletes such poses, and the first pose of every trajectory too, but not their
    images. Here rows are only marked, and the first pose stays.
    """
    is_jump = np.zeros(len(positions), dtype=bool)
    if len(positions) < 3:
        return is_jump
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    mean_so_far = np.cumsum(steps) / np.arange(1, len(steps) + 1)
    is_jump[1:] = steps > JUMP_FACTOR * mean_so_far
    is_jump[1] = False
    return is_jump


def is_pose(rows: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return a mask (n,) of rows (n, 7) that are poses: within a million metres, with a quaternion that can be
    normalised.
    """
    sizes = np.abs(rows)
    is_sane = np.all(sizes < FAR, axis=1, keepdims=True)  # false for NaN
    lengths = np.linalg.norm(np.where(is_sane, rows, 0.0)[:, 3:], axis=1)
    return is_sane[:, 0] & (lengths > 1e-6)


def _body_columns(header: list[list[str]], body: str, path: Path) -> list[int]:
    kinds, names = header[2], header[3]
    found = [
        at
        for at, name in enumerate(names)
        if name.strip() == body and at < len(kinds) and "marker" not in kinds[at].lower()
    ]
    if len(found) < 7:
        known = sorted({name.strip() for name in names if name.strip() and ":" not in name})
        raise _broken(path, f"the body {body!r} is not in it (it has {', '.join(known) or 'none'})")
    return found[:7]


def _number(row: list[str], at: int) -> float:
    text = row[at].strip() if at < len(row) else ""
    try:
        return float(text) if text else float("nan")
    except ValueError:
        return float("nan")


def _start(first: list[str]) -> str:
    return first[first.index(START_LABEL) + 1].strip() if START_LABEL in first[:-1] else ""


def _broken(path: Path, reason: str) -> BrokenLog:
    return BrokenLog(
        f"{path}: {reason}",
        f"an OptiTrack CSV export with {HEADER_ROWS} header rows",
        "Export it again.",
        file=str(path),
    )
