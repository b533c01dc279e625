"""Speed of an indenter along the gel at each frame, and the time for which it has stood by then."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array

WINDOW = 0.04
"""Time, s, before a moment over which the speed at that moment is averaged."""
SLOWEST = 5e-5
"""Speed, m/s, below which an indenter counts as standing."""
WAYS = (3e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3)
"""Distances, m, for each of which `last_ways` gives the time that the indenter has stayed within it."""
SURE = 5.0
"""Factor on the noise of the speed, as the noise of the positions makes it, above which a speed counts as moving."""


def last_move(frames: Array, seconds: Array, places: Array) -> tuple[Array, Array]:
    """Return pace (n,), m/s, and rest (n,), s, of an indenter at frames.

    The pace is its speed where it moves, and the greatest speed of its last move where it stands; 0 before any move.
    The rest is the time for which it has stood; 0 where it moves, and before any move.

    Parameters
    ----------
    frames : (n,) s
        Times of the frames.
    seconds : (m,) s, ascending
        Times of the positions, many to a move.
    places : (m, 2), m
        Positions along the gel.
    """
    nothing = np.zeros(len(frames))
    if len(seconds) < 3:
        return nothing, nothing.copy()
    # only what came before: frames are often taken just as the next move begins
    before = np.stack([np.interp(seconds - WINDOW, seconds, column) for column in places.T], axis=1)
    speeds = np.linalg.norm(places - before, axis=1) / WINDOW
    # a second difference of white noise is sqrt(6) times, the difference over the window sqrt(2) times as large
    bends = np.linalg.norm(np.diff(places, 2, axis=0), axis=1)
    noise = float(np.median(bends)) / np.sqrt(6.0) * np.sqrt(2.0) / WINDOW
    moving = speeds > max(SLOWEST, SURE * noise)
    # greatest speed of the move so far, kept while the indenter stands
    peaks = np.zeros(len(seconds))
    for row in range(1, len(seconds)):
        if moving[row]:
            peaks[row] = max(speeds[row], peaks[row - 1] if moving[row - 1] else 0.0)
        else:
            peaks[row] = peaks[row - 1]
    # the last position before each frame, and the last one of them in a move
    at = np.clip(np.searchsorted(seconds, frames, side="right") - 1, 0, len(seconds) - 1)
    last = np.maximum.accumulate(np.where(moving, np.arange(len(seconds)), -1))[at]
    moves = last == at
    pace = np.where(moves, speeds[at], peaks[at])
    rest = np.where(moves | (last < 0), 0.0, np.maximum(frames - seconds[np.maximum(last, 0)], 0.0))
    return np.where(last < 0, 0.0, pace), rest


def last_ways(frames: Array, seconds: Array, places: Array) -> Array:
    """Time (n, w), s, for which an indenter has been no further than each of ``WAYS`` from where it is at a frame.

    Parameters
    ----------
    frames : (n,) s
        Times of the frames.
    seconds : (m,) s, ascending
        Times of the positions.
    places : (m, 2), m
        Positions along the gel.
    """
    durations = np.zeros((len(frames), len(WAYS)))
    for row, moment in enumerate(frames):
        stop = int(np.searchsorted(seconds, moment, side="right"))
        if stop == 0:
            continue
        away = np.linalg.norm(places[:stop] - places[stop - 1], axis=1)
        for column, way in enumerate(WAYS):
            beyond = np.flatnonzero(away > way)
            durations[row, column] = moment - seconds[beyond[-1] if len(beyond) else 0]
    return durations
