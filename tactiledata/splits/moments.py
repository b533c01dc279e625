"""Moments: what several sensors of one recording took at the same time, such as the fingers of one gripper."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SIDES = {"train": "train", "val": "val", "test": "test", "test_unseen": "test"}
"""Side of each part: both tests are one side, since nothing is learned from either."""


def join_moments(
    together: NDArray[np.int64],
    group: NDArray[np.int64],
    founding: NDArray[np.bool_],
    source: NDArray[np.int64],
    start: NDArray[np.int64],
) -> tuple[NDArray[np.int64], dict[int, tuple[int, ...]]]:
    """Return by which row each recorded touch is drawn, so that what several sensors took at one moment stays together.

    A moment is what a recording holds of overlapping touches, whatever their sensors. Where a later recording repeats
    one of these touches, its own moment is that of the touch, so that what comes later moves nobody.

    Parameters
    ----------
    together : (n,) int
        Row of the touch that leads each moment within its recording.
    group : (n,) int
        Row of the touch that leads the group of each touch: those of one sensor that are one touch.
    founding : (n,) bool
        Whether a touch is of the recording that brought its group to the store.
    source : (n,) int
        Place of the recording in the store.
    start : (n,) int64 ns

    Returns
    -------
    moment : (n,) int64
        Row of the touch that leads each moment.
    met : dict, row -> leaders of moments
        Of touches whose recording repeats earlier ones: all moments that it repeats, the earliest first.
    """
    moments_of: dict[int, tuple[int, ...]] = {}
    met: dict[int, tuple[int, ...]] = {}
    order = np.lexsort((np.arange(len(together)), together, source))
    ends = np.flatnonzero(np.diff(together[order])) + 1
    for rows in np.split(order, ends) if len(order) else []:
        known = {moment for row in rows[~founding[rows]].tolist() for moment in moments_of[int(group[row])]}
        before = tuple(sorted(known, key=lambda row: (source[row], start[row], row)))
        for row in rows.tolist():
            if before:
                met[row] = before
            if founding[row]:
                moments_of[int(group[row])] = before or (int(together[row]),)
    return np.array([moments_of[leader][0] for leader in group.tolist()], np.int64), met
