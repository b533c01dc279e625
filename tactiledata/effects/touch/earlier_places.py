"""Positions of an indenter's tip shortly before and after each frame, and wrenches that are read late along its path.

Between two frames a tip moves and stands: forces follow its path, not the time. A wrench of some milliseconds ago is
that of the place where the tip was then.
"""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.touch.time_operators import delayed

DELAYS = (-0.32, -0.16, -0.08, -0.04, -0.02, -0.01, 0.0, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32)
"""Times, s, before a frame for which the place of the tip is known; negative after it."""
LEAST_WAY = 3e-6
"""Distance, m, between two frames' tips below which the tip stands: there the wrench follows the time."""


def earlier_places(frames: Array, seconds: Array, places: Array) -> Array:
    """Return the positions (n, d, 3), m, of a tip ``DELAYS`` before each frame; held before and after the stream.

    Parameters
    ----------
    frames : (n,) s
        Times of the frames.
    seconds : (m,) s, ascending
        Times of the positions, many to a move.
    places : (m, 3) m
        Positions of the tip.
    """
    if not len(seconds):
        return np.full((len(frames), len(DELAYS), 3), np.nan)
    at = frames[:, None] - np.array(DELAYS)
    return np.stack([np.interp(at, seconds, column) for column in places.T], axis=2)


def delayed_along(seconds: Array, wrench: Array, tips: Array, places: Array | None, delay: Array | float) -> Array:
    """Return the wrench (n, 6) as it was ``delay`` seconds earlier, linear along the path between frames.

    Where the tip stands, or where the delay is longer than the places reach, it is linear in time (`delayed`).

    Parameters
    ----------
    seconds : (n,) s, ascending
        Times of the frames.
    wrench : (n, 6) N, N m
        The wrench; rows that are NaN stay NaN.
    tips : (n, 3) m
        Positions of the tip at the frames.
    places : (n, d, 3) m, optional
        As `earlier_places` returns them; without them the wrench is linear in time.
    delay : float or (n,)
        Delay of each frame, s; negative for a wrench that comes early.
    """
    by_time = delayed(seconds, wrench, delay)
    if places is None:
        return by_time
    delays = np.broadcast_to(np.asarray(delay, dtype=np.float64), seconds.shape)
    known = np.flatnonzero(np.isfinite(wrench).all(axis=1) & np.isfinite(tips).all(axis=1))
    if len(known) < 2:
        return by_time
    # the two known frames between which each delayed moment lies
    at = seconds[known] - delays[known]
    after = np.clip(np.searchsorted(seconds[known], at, side="left"), 1, len(known) - 1)
    first, last = known[after - 1], known[after]
    # where the tip was then, as a share of the way between the two frames
    fine = np.array(DELAYS)
    upper = np.clip(np.searchsorted(fine, delays[known]), 1, len(fine) - 1)
    share = (delays[known] - fine[upper - 1]) / (fine[upper] - fine[upper - 1])
    place = places[known, upper - 1] + share[:, None] * (places[known, upper] - places[known, upper - 1])
    way = tips[last] - tips[first]
    square = (way**2).sum(axis=1)
    gone = np.clip(((place - tips[first]) * way).sum(axis=1) / np.maximum(square, 1e-300), 0.0, 1.0)
    along = wrench[first] + gone[:, None] * (wrench[last] - wrench[first])
    is_inside = (at >= seconds[known[0]]) & (at <= seconds[known[-1]])
    is_near = (delays[known] >= fine[0]) & (delays[known] <= fine[-1]) & np.isfinite(place).all(axis=1)
    moves = is_inside & is_near & (square > LEAST_WAY**2)
    late = by_time.copy()
    late[known[moves]] = along[moves]
    return late
