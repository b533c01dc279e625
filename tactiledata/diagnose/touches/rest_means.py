"""Means of force readings while the indenter stands, in place of a wrench interpolated between two readings.

A frame of a recording has one wrench, interpolated between two readings of the force sensor. While the indenter stands,
many readings say the same: their mean has less noise. The time of the frame becomes the mean time of its readings; its
pose is that of all of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array, Indices
from tactiledata.calibrate.touches import ForceReadings

STILL = 3e-6
"""Distance in metres within which a tip stands, beside the noise of its positions."""
LARGEST_JITTER = 5e-6
"""Standard deviation in metres of a position, above which it is not known when a tip stands."""
SLOWEST = 2e-4
"""Speed in m/s that a move has at least: a move is seen once it has gone as far as noise could."""
SPEED_WINDOW = 0.04
"""Seconds before a stop, or after the start of a move, over which its speed is measured."""
SETTLED = 0.05
"""Further seconds after a stop before the first reading: an arm swings on, and a clock may be off."""
BEFORE_MOVE = 0.01
"""Further seconds between the last reading and the next move, for a clock that is off."""
LONGEST = 1.0
"""Largest duration, in seconds, of the readings of one mean."""
SHARE_OF_REST = 0.25
"""Largest half-width of the readings of a mean, as a share of the time from the stop to their middle.

Forces relax fast after a stop and slowly later: within a quarter of the time they change almost in proportion to it."""
FEWEST_READINGS = 3
"""Fewest readings of a mean."""


@dataclass(frozen=True)
class FrameWrenches:
    """Wrenches at n frames, averaged where the indenter stands.

    Parameters
    ----------
    seconds : (n,) s
        Time of each wrench, strictly ascending where the frames are.
    wrench : (n, 6) N, N m
        NaN where unknown.
    readings : (n,)
        Number of readings of each mean; 0 where the wrench is interpolated.
    """

    seconds: Array
    wrench: Array
    readings: Indices


def rest_spans(frames: Array, seconds: Array, places: Array) -> Array:
    """Return when readings say the same as each frame (n, 2), s: start and end, NaN where the indenter moves.

    Spans of different frames do not overlap. They begin some time after a stop (``SETTLED``) and end some time before
    the next move (``BEFORE_MOVE``); nothing is left out where the stream of positions begins or ends.

    Parameters
    ----------
    frames : (n,) s, ascending
        Times of the frames.
    seconds : (m,) s, ascending
        Times of the positions.
    places : (m, 3) m
        Positions of the tip.
    """
    spans = np.full((len(frames), 2), np.nan)
    jitter = position_jitter(places)
    if len(seconds) < 2 or jitter > LARGEST_JITTER:
        return spans
    # halfway to the neighbouring frames
    middles = (frames[1:] + frames[:-1]) / 2
    lower, upper = np.concatenate([[-np.inf], middles]), np.concatenate([middles, [np.inf]])
    for place, time in enumerate(frames):
        if not seconds[0] <= time <= seconds[-1]:
            continue
        rest = _rest_about(time, seconds, places, jitter)
        if not rest.start <= time <= rest.end + rest.unseen_start:
            continue
        since = max(rest.stop, seconds[0] - LONGEST / SHARE_OF_REST)
        end = min(rest.end, upper[place], time + SHARE_OF_REST * (time - since), time + LONGEST / 2)
        # (end - start) / 2 = SHARE_OF_REST * (middle - since)
        widest = ((1.0 - SHARE_OF_REST) * end + 2.0 * SHARE_OF_REST * since) / (1.0 + SHARE_OF_REST)
        start = max(rest.start, lower[place], widest, end - LONGEST)
        if start < end:
            spans[place] = start, end
    return spans


@dataclass(frozen=True)
class _Rest:
    """A time for which a tip stands.

    Parameters
    ----------
    stop : s
        When it stopped; minus infinity where it has stood since the positions begin.
    start, end : s
        From when to when readings are used.
    unseen_start : s
        Time before the next move that is left out of the readings.
    """

    stop: float
    start: float
    end: float
    unseen_start: float


def _rest_about(time: float, seconds: Array, places: Array, jitter: float) -> _Rest:
    """Return the rest at a time; it is empty in a move.

    Parameters
    ----------
    time : s
        The time.
    seconds : (m,) s
        Times of the positions.
    places : (m, 3) m
        Positions of the tip.
    jitter : m
        Standard deviation of their noise.
    """
    limit = STILL + 4.0 * jitter
    here = int(np.argmin(np.abs(seconds - time)))
    # a single position has noise of its own: from the median of those about it, a move is seen sooner
    first, last = _within(limit, _distances(places, places[here]), here)
    away = _distances(places, np.median(places[first : last + 1], axis=0))
    first, last = _within(limit, away, here)
    stop, start, end, unseen_start = -np.inf, float(seconds[0]), float(seconds[-1]), 0.0
    if first > 0:
        stop = float(seconds[first])
        start = stop + SETTLED + limit / _speed(away - limit, jitter, seconds, stop - SPEED_WINDOW)
    if last < len(seconds) - 1:
        move = float(seconds[last])
        unseen_start = BEFORE_MOVE + limit / _speed(away - limit, jitter, seconds, move + SPEED_WINDOW)
        end = move - unseen_start
    return _Rest(stop, start, end, unseen_start)


def _distances(places: Array, middle: Array) -> Array:
    """Return the distances (m,), m, of positions (m, 3) from a position (3,)."""
    return np.asarray(np.linalg.norm(places - middle, axis=1))


def _within(limit: float, away: Array, here: int) -> tuple[int, int]:
    """Return the first and the last index about ``here`` between which every distance (m,) is at most ``limit``, m."""
    beyond = np.flatnonzero(away > limit)
    before, after = beyond[beyond < here], beyond[beyond > here]
    return int(before[-1]) + 1 if len(before) else 0, int(after[0]) - 1 if len(after) else len(away) - 1


def _speed(away: Array, jitter: float, seconds: Array, at: float) -> float:
    """Return the least mean speed, m/s, that a move has between where it is seen and ``SPEED_WINDOW`` before or after.

    It is at least ``SLOWEST``.

    Parameters
    ----------
    away : (m,) m
        Distance from where the move is seen first or last.
    jitter : m
        Standard deviation of the noise of a position.
    seconds : (m,) s
        Times of the positions.
    at : s
        The time.
    """
    return max((float(np.interp(at, seconds, away)) - 3.0 * jitter) / SPEED_WINDOW, SLOWEST)


def position_jitter(places: Array) -> float:
    """Return the standard deviation, m, of the noise of positions (m, 3), from their second differences.

    A straight move at constant speed has none; the median leaves out starts and stops.
    """
    if len(places) < 3:
        return 0.0
    seconds = np.abs(np.diff(places, n=2, axis=0))
    # the second difference of white noise has six times its variance; a normal's median size is 0.6745 deviations
    return float(np.max(np.median(seconds, axis=0)) / (0.6745 * np.sqrt(6.0)))


def means_at_rest(frames: Array, wrench: Array, spans: Array, readings: ForceReadings) -> FrameWrenches:
    """Return the wrenches at frames, replaced by means of readings where there are enough.

    A frame keeps its interpolated wrench where a reading within its span is unknown.

    Parameters
    ----------
    frames : (n,) s, ascending
        Times of the frames.
    wrench : (n, 6) N, N m
        Interpolated wrenches; an unknown one stays unknown.
    spans : (n, 2) s
        As `rest_spans` returns them.
    readings : ForceReadings
        Readings of the same trajectory.
    """
    times, means, counts = frames.copy(), wrench.copy(), np.zeros(len(frames), dtype=np.int64)
    known = np.asarray(np.isfinite(readings.wrench).all(axis=1))
    for place in np.flatnonzero(np.isfinite(spans).all(axis=1) & np.isfinite(wrench).all(axis=1)):
        inside = slice(
            int(np.searchsorted(readings.seconds, spans[place, 0], side="left")),
            int(np.searchsorted(readings.seconds, spans[place, 1], side="left")),
        )
        count = inside.stop - inside.start
        if count < FEWEST_READINGS or not known[inside].all():
            continue
        times[place] = readings.seconds[inside].mean()
        means[place] = readings.wrench[inside].mean(axis=0)
        counts[place] = count
    return FrameWrenches(times, means, counts)
