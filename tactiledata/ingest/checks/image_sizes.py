"""Images of another size than the others of their sensor: marked where they are strays, named in any case."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.contract.image_sizes import Size, share_words, stray_sizes, usual_size, words_of
from tactiledata.contract.records import Finding
from tactiledata.contract.take import UNUSABLE, FrameFlag

MOST_NAMED = 3
"""Images, or sizes, that a sentence names."""


def size_counts(frames: pa.Table) -> dict[str, Counter[Size]]:
    """How many usable images of each sensor have each size, by the table of frames."""
    usable = np.flatnonzero((frames["flags"].to_numpy() & UNUSABLE) == 0)
    chosen = frames.select(["sensor", "height", "width"]).take(pa.array(usable))
    columns = (chosen[name].to_pylist() for name in ("sensor", "height", "width"))
    counts: dict[str, Counter[Size]] = {}
    for sensor, height, width in zip(*columns, strict=True):
        counts.setdefault(sensor, Counter())[height, width] += 1
    return counts


def mark_strays(frames: pa.Table, names: list[str]) -> tuple[pa.Table, list[Finding]]:
    """The table of frames with strays of size flagged, and what is said of sensors whose images differ in size.

    Parameters
    ----------
    frames : pa.Table
        ``FRAME_SCHEMA``
    names : list of str
        Names of the trajectories, by row of the table of trajectories.
    """
    flags = frames["flags"].to_numpy().copy()
    sensors = np.array(frames["sensor"].to_pylist(), dtype=object)
    height, width = (frames[name].to_numpy().astype(np.int64) for name in ("height", "width"))
    findings: list[Finding] = []
    for sensor, counts in sorted(size_counts(frames).items()):
        strays = stray_sizes(counts)
        mine = (sensors == sensor) & ((flags & UNUSABLE) == 0)
        for size in sorted(strays):
            rows = np.flatnonzero(mine & (height == size[0]) & (width == size[1]))
            findings.append(_stray_finding(sensor, counts, size, _places(frames, rows, names)))
            flags[rows] |= FrameFlag.STRAY_SIZE
        if len(counts) - len(strays) > 1:
            findings.append(_mixed_finding(sensor, counts))
    column = frames.schema.get_field_index("flags")
    return frames.set_column(column, frames.schema.field("flags"), pa.array(flags)), findings


def _stray_finding(sensor: str, counts: Counter[Size], size: Size, places: str) -> Finding:
    total, usual = sum(counts.values()), usual_size(counts)
    rest = total - counts[size]
    others = f"the other {rest} are" if counts[usual] == rest else f"{counts[usual]} are"
    text = (
        f"{share_words(counts[size], total, size)} (rows x columns), of sensor {sensor!r}; {others} {words_of(usual)}: "
        f"{places}. The bytes are kept as they came, and training leaves them out"
    )
    return Finding("image-stray-size", "warning", text, count=counts[size])


def _mixed_finding(sensor: str, counts: Counter[Size]) -> Finding:
    listed = ", ".join(f"{count} of {words_of(size)}" for size, count in counts.most_common(MOST_NAMED))
    text = (
        f"images of sensor {sensor!r} have several sizes (rows x columns): {listed}. A dataset takes one size: "
        "record one size, or scale the images before they are ingested"
    )
    return Finding("image-sizes-mixed", "warning", text, count=sum(counts.values()) - max(counts.values()))


def _places(frames: pa.Table, rows: NDArray[np.int64], names: list[str]) -> str:
    """The first of some frames by trajectory, number in it (from 0) and time."""
    trajectory, t_ns = frames["trajectory"].to_numpy(), frames["t_ns"].to_numpy()
    placed = []
    for row in rows[:MOST_NAMED]:
        owner = int(trajectory[row])
        number = row - int(np.argmax(trajectory == owner))
        where = f"frame {number} of trajectory {names[owner]!r}" if owner >= 0 else "a frame outside trajectories"
        placed.append(f"{where} (t_ns {t_ns[row]})")
    more = f" and {len(rows) - MOST_NAMED} more" if len(rows) > MOST_NAMED else ""
    return ", ".join(placed) + more
