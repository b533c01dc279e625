"""Acceleration of a tool that vibrates on the arm while the arm moves, for one mode of vibration."""

from __future__ import annotations

from functools import cache

import numpy as np

from tactiledata.arrays import Array

FREQUENCIES = tuple(float(f) for f in np.geomspace(6.0, 40.0, 39).round(2))
"""Frequencies of the modes, Hz, a twentieth apart: the lowest ones of an arm lie between 10 and 25 Hz."""
DAMPING = 0.1
"""Damping ratio of a mode; the lowest modes of an arm have 0.03 to 0.15, an estimate."""
RATE = 500.0
"""Rate, Hz, at which a mode is integrated: more than ten steps for a period of the fastest."""
GAP = 2.0
"""Time, s, without a position after which a mode is taken to be at rest, wherever the tip is by then."""


def felt_accelerations(frames: Array, seconds: Array, places: Array) -> Array:
    """Accelerations (n, f, 3), m/s^2, at frames of a mass that each mode of ``FREQUENCIES`` holds to the tip.

    u'' + 2 d w u' + w^2 u = w^2 x for the mass at u, the tip at x, and w = 2 pi f; the result is u''. No position is
    differentiated twice: noise of standard deviation s in the positions becomes w^2 s at most. The tip moves evenly
    between positions. After a ``GAP`` a mode starts again, at rest.

    Source: a harmonic oscillator on a moving base; D. J. Inman, Engineering Vibration, ch. 2.4.

    Parameters
    ----------
    frames : (n,) s
        Times of the frames.
    seconds : (m,) s, ascending
        Times of the positions, many to a move; before the first the tip stood still.
    places : (m, 3), m
        Positions of the tip, gel frame.
    """
    felt = np.zeros((len(frames), len(FREQUENCIES), 3))
    for rows in np.split(np.arange(len(seconds)), np.flatnonzero(np.diff(seconds) > GAP) + 1):
        if len(rows) < 2:
            continue
        covered = (frames >= seconds[rows[0]]) & (frames <= seconds[rows[-1]] + GAP)
        if not covered.any():
            continue
        felt[covered] = _felt_without_gap(frames[covered], seconds[rows], places[rows])
    return felt


def _felt_without_gap(frames: Array, seconds: Array, places: Array) -> Array:
    """Accelerations (n, f, 3), m/s^2, for positions without gaps that start before the frames and end near them."""
    from scipy.signal import lfilter

    felt = np.zeros((len(frames), len(FREQUENCIES), 3))
    even = np.arange(seconds[0], max(seconds[-1], frames.max()) + 2.0 / RATE, 1.0 / RATE)
    way = np.stack([np.interp(even, seconds, column) for column in (places - places[0]).T], axis=1)
    for column, frequency in enumerate(FREQUENCIES):
        swung = lfilter(*_mode(frequency), way, axis=0)
        felt[:, column] = np.stack([np.interp(frames, even, axis) for axis in swung.T], axis=1)
    return felt


def felt_at(felt: Array, frequency: float) -> Array:
    """Accelerations (n, 3), m/s^2, of the mode of a frequency, Hz, interpolated in those of `felt_accelerations`."""
    place = float(np.interp(np.log(frequency), np.log(FREQUENCIES), np.arange(len(FREQUENCIES))))
    below = min(int(place), len(FREQUENCIES) - 2)
    share = place - below
    between: Array = (1.0 - share) * felt[:, below] + share * felt[:, below + 1]
    return between


@cache
def _mode(frequency: float) -> tuple[Array, Array]:
    """Numerator and denominator of the filter w^2 s^2 / (s^2 + 2 d w s + w^2), w = 2 pi frequency, at ``RATE``."""
    from scipy.signal import cont2discrete

    w = 2.0 * np.pi * frequency
    top, bottom, _ = cont2discrete(([w * w, 0.0, 0.0], [1.0, 2.0 * DAMPING * w, w * w]), 1.0 / RATE, method="foh")
    return np.ravel(top), np.ravel(bottom)
