"""How fast an indenter moved along the gel when a frame was taken, or for how long it had stood by then."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array

WINDOW = 0.04
"""s before a moment over which its speed is taken."""
SLOWEST = 5e-5
"""m/s: slower is standing."""
WAYS = (3e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3)
"""m: for so long ways before a moment it is told how long they took."""
SURE = 5.0
"""Times what noise of the positions makes of the speed."""


def last_move(frames: Array, seconds: Array, places: Array) -> tuple[Array, Array]:
    """Pace (n,), m/s, and rest (n,), s, at frames.

    Pace is the speed where the indenter moves, and the greatest of its last move where it stands; 0 before any.

    Parameters
    ----------
    frames : (n,) s
    seconds : (m,) s, ascending
        Of the positions, many to a move.
    places : (m, 2), m
        Along the gel.
    """
    nothing = np.zeros(len(frames))
    if len(seconds) < 3:
        return nothing, nothing.copy()
    # only what came before: frames are often taken just as the next move begins
    before = np.stack([np.interp(seconds - WINDOW, seconds, column) for column in places.T], axis=1)
    speeds = np.linalg.norm(places - before, axis=1) / WINDOW
    bends = np.linalg.norm(np.diff(places, 2, axis=0), axis=1)
    noise = float(np.median(bends)) / np.sqrt(6.0) * np.sqrt(2.0) / WINDOW
    moving = speeds > max(SLOWEST, SURE * noise)
    peaks = np.zeros(len(seconds))
    for row in range(1, len(seconds)):
        if moving[row]:
            peaks[row] = max(speeds[row], peaks[row - 1] if moving[row - 1] else 0.0)
        else:
            peaks[row] = peaks[row - 1]
    at = np.clip(np.searchsorted(seconds, frames, side="right") - 1, 0, len(seconds) - 1)
    last = np.maximum.accumulate(np.where(moving, np.arange(len(seconds)), -1))[at]
    moves = last == at
    pace = np.where(moves, speeds[at], peaks[at])
    rest = np.where(moves | (last < 0), 0.0, np.maximum(frames - seconds[np.maximum(last, 0)], 0.0))
    return np.where(last < 0, 0.0, pace), rest


def last_ways(frames: Array, seconds: Array, places: Array) -> Array:
    """For how long (n, w), s, an indenter has been no further than each of ``WAYS`` from where it is at frames (n,), s.

    Seconds (m,) and places (m, 2) are those of `last_move`.
    """
    found = np.zeros((len(frames), len(WAYS)))
    for row, moment in enumerate(frames):
        stop = int(np.searchsorted(seconds, moment, side="right"))
        if stop == 0:
            continue
        away = np.linalg.norm(places[:stop] - places[stop - 1], axis=1)
        for column, way in enumerate(WAYS):
            beyond = np.flatnonzero(away > way)
            found[row, column] = moment - seconds[beyond[-1] if len(beyond) else 0]
    return found
