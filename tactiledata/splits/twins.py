"""Twins: touches that several recordings hold, such as an edited copy of a log or a damaged copy of a bag."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.wording import agreeing, counted, listed

ABSOLUTE_NS = 10**18
"""9 September 2001. Earlier times are counted from the start of a recording or of a machine: they tell no moment."""
UNNAMED = "unknown-"
"""How the made-up names of sensors begin that their recording does not name."""

NAME_IT = "name the serial in a description or a mapping, and ingest again"
"""What to do about a sensor without a serial."""
MOST_UNNAMED = 3
"""Sensors without a serial that a sentence lists."""


def unnamed_sensors(sensors: Iterable[str]) -> str:
    """Say which of the sensors have no serial, and that they may be one camera; empty where all have one.

    Parameters
    ----------
    sensors : iterable of str
        Names of sensors in a store, each once.
    """
    unnamed = [name for name in sensors if name.startswith(UNNAMED)]
    if not unnamed:
        return ""
    fewer = agreeing(len(unnamed), "be one of the other cameras", "be fewer cameras than that")
    return f"{counted(len(unnamed), 'sensor')} without a serial ({listed(unnamed, MOST_UNNAMED)}) may {fewer}"


def tells_a_moment(start: NDArray[np.int64], sensor_is_named: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether touches (n,) can be compared across recordings: absolute times ``start`` (n,) ns, of a named sensor."""
    return (start >= ABSOLUTE_NS) & sensor_is_named


def join_twins(
    cluster: NDArray[np.int64],
    component: NDArray[np.int64],
    source: NDArray[np.int64],
    start: NDArray[np.int64],
    end: NDArray[np.int64],
) -> dict[int, tuple[int, ...]]:
    """Return, for each cluster of touches, the clusters of earlier recordings that it repeats.

    Recordings are gone through in the order in which they came to the store, so that what comes later joins what is
    there, and never moves it.

    Parameters
    ----------
    cluster : (n,) int
        Row of the touch that leads each one within its recording.
    component : (n,) int
        Equal for touches that overlap across recordings, directly or through others.
    source : (n,) int
        Place of the recording in the store.
    start, end : (n,) int64 ns
        Half-open intervals.

    Returns
    -------
    dict, leader of a cluster -> leaders of the groups it overlaps
        Only clusters that join; the earliest group first. Several, where it bridges groups that were apart.
    """
    joined: dict[int, tuple[int, ...]] = {}
    for rows in _over_several_sources(component, source):
        first_row = np.unique(cluster[rows], return_index=True)[1]
        order = rows[first_row][np.argsort(source[rows][first_row], kind="stable")]
        seen = np.empty(0, np.int64)
        for leader in cluster[order].tolist():
            members = rows[cluster[rows] == leader]
            touching = [seen[(start[seen] < end[row]) & (end[seen] > start[row])] for row in members]
            met = dict.fromkeys(cluster[np.unique(np.concatenate(touching))].tolist())
            groups = dict.fromkeys(group for other in met for group in joined.get(other, (other,)))
            if groups:
                joined[leader] = tuple(sorted(groups, key=lambda group: (source[group], start[group], group)))
            seen = np.concatenate([seen, members])
    return joined


def _over_several_sources(component: NDArray[np.int64], source: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    """Rows of each component that spans several recordings, in ascending order."""
    order = np.argsort(component, kind="stable")
    ends = np.flatnonzero(np.diff(component[order])) + 1
    mixed = np.zeros(len(order), bool)
    mixed[1:] = (np.diff(component[order]) == 0) & (np.diff(source[order]) != 0)
    counts = np.concatenate([[0], np.cumsum(mixed)])
    for first, last in zip([0, *ends], [*ends, len(order)], strict=True):
        if counts[last] > counts[first]:
            yield order[first:last]
