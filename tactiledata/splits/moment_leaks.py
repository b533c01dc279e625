"""Leaks between sensors: what several of them took at one moment and a split puts on different sides."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from tactiledata.contract.records import Finding
from tactiledata.contract.wording import counted
from tactiledata.splits.groups import codes, overlapping_touches
from tactiledata.splits.leaks import SHOWN, groups_in_several_parts, leak
from tactiledata.splits.moments import SIDES
from tactiledata.splits.options import PARTITIONS
from tactiledata.splits.twins import tells_a_moment

SIDE_OF = np.array([PARTITIONS.index(SIDES[part]) for part in PARTITIONS], np.int64)
"""Code of each part's side, by the code of the part."""


def parted_moments(trajectories: pa.Table, part: NDArray[np.int64]) -> list[Finding]:
    """Recorded trajectories of several sensors of one recording that overlap in time and stand on different sides.

    Parameters
    ----------
    trajectories : pa.Table
        ``TRAJECTORY_SCHEMA``, n rows.
    part : (n,) int
        Codes of `leaks.partition_codes`.
    """
    rows = _recorded(trajectories, part)
    source, sensor, start, end = _facts(trajectories, rows)
    leader = overlapping_touches(source, start, end)
    side = SIDE_OF[part[rows]]
    parted = [group for group in groups_in_several_parts(leader, side) if _several(sensor[leader == group])]
    names, sensors = trajectories["trajectory"], trajectories["sensor"]

    def cases() -> Iterable[str]:
        for group in parted:
            members = rows[leader == group]
            shown = members[np.unique(SIDE_OF[part[members]], return_index=True)[1]]
            yield " and ".join(
                f"{names[int(row)].as_py()!r} of sensor {sensors[int(row)].as_py()} ({PARTITIONS[part[row]]})"
                for row in shown
            )

    what = "trajectories that several sensors of a recording took at one moment are in different parts"
    return leak("moment-in-two-parts", what, cases(), len(parted))


def parted_recordings(trajectories: pa.Table, part: NDArray[np.int64]) -> list[Finding]:
    """A warning of touches that sensors of different recordings took at one moment and that stand on different sides.

    Two recordings may be of two rigs that ran at one time, or of two fingers of one gripper: nobody can tell from the
    tables. Arguments as in `parted_moments`; only times that tell a moment are compared.
    """
    rows = _recorded(trajectories, part)
    named = pc.not_equal(trajectories["sensor"].combine_chunks().cast(pa.string()), "")
    is_absolute = tells_a_moment(trajectories["start_ns"].to_numpy(), named.to_numpy(zero_copy_only=False))
    rows = rows[is_absolute[rows]]
    source, sensor, start, end = _facts(trajectories, rows)
    rows, source, sensor, start, end = (values[end > start] for values in (rows, source, sensor, start, end))
    side = SIDE_OF[part[rows]]
    place = source * (int(sensor.max(initial=0)) + 1) + sensor
    met = np.zeros(len(rows), np.int64)
    # all that overlap, less those of the same recording, less those of the same sensor, and both are in the two
    for sign, among in ((1, np.zeros_like(source)), (-1, source), (-1, sensor), (1, place)):
        met += sign * (_overlapping(among, start, end) - _overlapping(among * len(PARTITIONS) + side, start, end))
    apart = rows[met > 0]
    if not len(apart):
        return []
    names = ", ".join(repr(trajectories["trajectory"][int(row)].as_py()) for row in apart[:SHOWN])
    message = (
        f"{counted(len(apart), 'trajectory')} ({names}{' …' * (len(apart) > SHOWN)}) overlap in time with those of "
        "another sensor in another recording, and stand in different parts. Two rigs that ran at one time share "
        "nothing; two sensors on one gripper saw one touch: record them into one log, and `split` keeps them together"
    )
    return [Finding("moment-in-two-recordings", "warning", message, count=len(apart))]


def _recorded(trajectories: pa.Table, part: NDArray[np.int64]) -> NDArray[np.int64]:
    """Rows of recorded trajectories that are in a part."""
    return np.flatnonzero((part >= 0) & pc.equal(trajectories["parent"], "").to_numpy())


def _facts(trajectories: pa.Table, rows: NDArray[np.int64]) -> tuple[NDArray[np.int64], ...]:
    """Recording, code of the sensor, start and end (each (n,)) of rows."""
    columns = (trajectories[name].to_numpy() for name in ("start_ns", "end_ns"))
    source = trajectories["source"].to_numpy().astype(np.int64)
    return tuple(values[rows] for values in (source, codes(trajectories["sensor"]), *columns))


def _several(values: NDArray[np.int64]) -> bool:
    return len(np.unique(values)) > 1


def _overlapping(place: NDArray[np.int64], start: NDArray[np.int64], end: NDArray[np.int64]) -> NDArray[np.int64]:
    """How many intervals (n,) of its place each one overlaps, itself included; none of them is empty."""
    ranks = np.unique(np.concatenate([start, end]), return_inverse=True)[1].reshape(2, -1)
    base = np.unique(place, return_inverse=True)[1] * (2 * len(place) + 1)
    first, last = np.sort(base + ranks[0]), np.sort(base + ranks[1])
    return np.asarray(np.searchsorted(first, base + ranks[1]) - np.searchsorted(last, base + ranks[0], side="right"))
