"""Which frames of a long trajectory are simulated: corners of its path first, then what lies between them."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array, Indices

CORNER = 2e-5
"""Largest distance, m, of the tip from the straight moves between chosen frames, beyond which a frame is a corner."""
SHARE_OF_CORNERS = 2 / 3
"""Largest share of the frames that are chosen as corners of the path."""


def chosen_frames(seconds: Array, places: Array, most: int) -> Indices:
    """Return the numbers (k,), ascending, of at most ``most`` frames that stand for a trajectory.

    All are returned where there are no more than that. Otherwise the first and the last frame are chosen, then one at a
    time the frame whose tip is farthest from the straight moves between those chosen: starts and ends of dwells, and
    points at which a slide turns (Ramer, Computer Graphics and Image Processing 1, 1972; Douglas and Peucker,
    Cartographica 10, 1973). What remains divides the longest gaps, measured in time and in the length of the path.
    Frames whose place is unknown are not chosen.

    Parameters
    ----------
    seconds : (n,) s, ascending
        Times of the frames.
    places : (n, 3) m
        Positions of the tip; NaN where unknown.
    most : int
        Largest number of frames, at least 2.
    """
    if len(seconds) <= most:
        return np.arange(len(seconds))
    known = np.flatnonzero(np.isfinite(places).all(axis=1))
    if len(known) <= most:
        return known
    times, path = seconds[known], places[known]
    chosen = [0, len(known) - 1]
    while len(chosen) < SHARE_OF_CORNERS * most:
        order = np.sort(chosen)
        straight = np.column_stack([np.interp(times, times[order], column[order]) for column in path.T])
        away = np.linalg.norm(path - straight, axis=1)
        farthest = int(np.argmax(away))
        if away[farthest] <= CORNER:
            break
        chosen.append(farthest)
    # distance along the trajectory: half of it is time, half the length of the path
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    along = (times - times[0]) / max(float(times[-1] - times[0]), 1e-300) + lengths / max(float(lengths[-1]), 1e-300)
    while len(chosen) < most:
        order = np.sort(chosen)
        # gaps without a frame inside cannot be divided
        gaps = np.where(np.diff(order) > 1, np.diff(along[order]), -1.0)
        widest = int(np.argmax(gaps))
        first, last = order[widest], order[widest + 1]
        middle = (along[first] + along[last]) / 2
        chosen.append(first + 1 + int(np.argmin(np.abs(along[first + 1 : last] - middle))))
    return known[np.sort(chosen)]
