"""What a tool that swings on the arm feels of a move: accelerations through one mode of vibration."""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.signal import cont2discrete, lfilter

from tactiledata.arrays import Array

FREQUENCIES = tuple(float(f) for f in np.geomspace(6.0, 40.0, 39).round(2))
"""Hz of modes, a twentieth apart: an arm's lowest ones lie between 10 and 25 Hz."""
DAMPING = 0.1
"""Share of the critical damping of such a mode; an arm's lowest have 0.03 to 0.15, an estimate."""
RATE = 500.0
"""Hz at which modes are followed, ten times a swing of the fastest."""
GAP = 2.0
"""s without a position, after which a mode has come to rest, wherever the tip is by then."""


def felt_accelerations(frames: Array, seconds: Array, places: Array) -> Array:
    """Accelerations (n, f, 3), m/s^2, at frames of a mass that each mode of ``FREQUENCIES`` holds to the tip.

    u'' + 2 d w u' + w^2 u = w^2 x for the mass at u, the tip at x, and w = 2 pi f; given is u''. Nothing is
    differentiated twice: noise of the places, s, becomes w^2 s at most. Between positions the tip moves evenly; after a
    ``GAP`` it begins anew, at rest.

    Source: a harmonic oscillator on a moving base; D. J. Inman, Engineering Vibration, ch. 2.4.

    Parameters
    ----------
    frames : (n,) s
    seconds : (m,) s, ascending
        Of the positions, many to a move; before the first the tip has stood.
    places : (m, 3), m
    """
    felt = np.zeros((len(frames), len(FREQUENCIES), 3))
    for rows in np.split(np.arange(len(seconds)), np.flatnonzero(np.diff(seconds) > GAP) + 1):
        if len(rows) < 2:
            continue
        told = (frames >= seconds[rows[0]]) & (frames <= seconds[rows[-1]] + GAP)
        if not told.any():
            continue
        felt[told] = _felt_in_one_go(frames[told], seconds[rows], places[rows])
    return felt


def _felt_in_one_go(frames: Array, seconds: Array, places: Array) -> Array:
    """Of a stream without gaps, which begins before the frames and ends not long before them."""
    felt = np.zeros((len(frames), len(FREQUENCIES), 3))
    even = np.arange(seconds[0], max(seconds[-1], frames.max()) + 2.0 / RATE, 1.0 / RATE)
    way = np.stack([np.interp(even, seconds, column) for column in (places - places[0]).T], axis=1)
    for column, frequency in enumerate(FREQUENCIES):
        swung = lfilter(*_mode(frequency), way, axis=0)
        felt[:, column] = np.stack([np.interp(frames, even, one) for one in swung.T], axis=1)
    return felt


def felt_at(felt: Array, frequency: float) -> Array:
    """Of `felt_accelerations` (n, f, 3) those (n, 3) of a frequency, Hz, between neighbouring ones in proportion."""
    place = float(np.interp(np.log(frequency), np.log(FREQUENCIES), np.arange(len(FREQUENCIES))))
    below = min(int(place), len(FREQUENCIES) - 2)
    share = place - below
    between: Array = (1.0 - share) * felt[:, below] + share * felt[:, below + 1]
    return between


@cache
def _mode(frequency: float) -> tuple[Array, Array]:
    """Numerator and denominator, at ``RATE``, of w^2 s^2 / (s^2 + 2 d w s + w^2)."""
    w = 2.0 * np.pi * frequency
    top, bottom, _ = cont2discrete(([w * w, 0.0, 0.0], [1.0, 2.0 * DAMPING * w, w * w]), 1.0 / RATE, method="foh")
    return np.ravel(top), np.ravel(bottom)
