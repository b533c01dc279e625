"""When a force shows contact: the noise of a reading, the threshold of a touch, and the free air before it."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import binary_opening, uniform_filter1d

from tactiledata.contract.records import Times, Values

TOUCH = 0.5
"""N. Change of force against free air that counts as a touch, where the noise is smaller."""

RELEASE_SHARE = 0.5
"""A touch ends when the force falls below this share of the touching threshold."""

SIGMAS = 6.0
"""Standard deviations of the noise of a force's norm, about, at which a force counts as a touch."""

MIN_FREE_AIR = 10
"""Samples without contact that a zero is taken from, at least."""

SURELY_FREE = 0.5
"""Share of the samples before a touch is noticed that is free air for sure: a slow press is under the threshold for as
long as it was in the air, and the median of both was up to 0.1 N off."""

LIGHT_FREE = 0.7
"""Share of the samples before averages show a light touch that is free air for sure; they show it earlier than single
readings do."""

AVERAGED = 0.3
"""Seconds over which readings are averaged where a light touch is sought: more than a period of an arm's vibration."""

LASTS = 0.5
"""Seconds for which the averaged force must stay away from free air to be a light touch; a move begins faster."""

LIGHT_TOUCH = 0.2
"""N. Change of the averaged force that counts as a light touch, where the noise of the average is smaller."""

QUARTER = 1.1012
"""Lower quartile of the length of three independent normal numbers, in standard deviations of one."""


def component_noise(load: Values) -> float:
    """Standard deviation (N) of one force component, from the differences of neighbouring samples that differ."""
    steps = np.diff(load[:, :3], axis=0)
    steps = steps[(steps != 0).any(axis=1)]
    if not len(steps):
        return 0.0
    return float(np.median(np.abs(steps)) / 0.6745 / np.sqrt(2))


def touching(force: Values, threshold: float) -> np.ndarray:
    """Whether each sample (n,) of a force norm is in contact: above the threshold, until it falls below half of it."""
    above = force > threshold
    below = force < RELEASE_SHARE * threshold
    change = np.where(above, 1, np.where(below, -1, 0))
    known = change != 0
    # every undecided sample takes the state of the last decided one; before any decision there is no contact
    last = np.maximum.accumulate(np.where(known, np.arange(len(change)), -1))
    return np.where(last >= 0, change[np.maximum(last, 0)] > 0, False)


def touch_threshold(noise: float) -> float:
    """N. Six standard deviations of the force norm's noise, at least `TOUCH`."""
    return max(TOUCH, SIGMAS * noise * np.sqrt(3))


def light_touch(load: Values, t_ns: Times) -> int:
    """Number of samples before the averaged force leaves the level of the beginning to stay away; all where it stays.

    A press of half a newton is hardly over the threshold of single readings. Averages over `AVERAGED` show it. What is
    over within `LASTS`, such as the push of an arm that starts, is no touch.

    Parameters
    ----------
    load : (n, 6) N, N m
        Finite samples that begin in free air, without jumps of the zero.
    t_ns : (n,) int64
        Time of each sample in ns.
    """
    period = max(float(np.median(np.diff(t_ns))) * 1e-9, 1e-9) if len(t_ns) > 1 else 1.0
    width, least = (max(1, round(seconds / period)) for seconds in (AVERAGED, LASTS))
    force = load[:, :3]
    if len(force) < 4 * width + least:
        return len(force)
    averaged = uniform_filter1d(force, width, axis=0, mode="nearest")
    # noise of an average: in a quarter of all places at least, neighbouring averages differ by nothing else
    changes = np.linalg.norm(averaged[width:] - averaged[:-width], axis=1)
    noise = float(np.quantile(changes, 0.25) / QUARTER / np.sqrt(2))
    threshold = max(LIGHT_TOUCH, SIGMAS * noise * np.sqrt(3))
    away = np.linalg.norm(averaged - np.median(force[: max(MIN_FREE_AIR, width)], axis=0), axis=1) > threshold
    touched = np.flatnonzero(binary_opening(away, np.ones(least, dtype=bool)))
    return int(touched[0]) if len(touched) else len(force)


def before_touch(first: int, load: Values, t_ns: Times) -> int:
    """Number of samples before a touch is noticed, of which the share `SURELY_FREE` is free air for sure.

    Parameters
    ----------
    first : int
        Number of samples before single readings show a touch; all where they show none.
    load : (n, 6) N, N m
        As for `light_touch`.
    t_ns : (n,) int64
        Time of each sample in ns.
    """
    return min(first, int(LIGHT_FREE / SURELY_FREE * light_touch(load, t_ns)))


def surely_free(load: Values, t_ns: Times) -> int:
    """Number of samples that were surely taken before the contact: half of those before a touch is noticed.

    Parameters
    ----------
    load : (n, 6) N, N m
        Finite samples about their zero, which begin in free air.
    t_ns : (n,) int64
        Time of each sample in ns.
    """
    contact = np.flatnonzero(touching(np.linalg.norm(load[:, :3], axis=1), touch_threshold(component_noise(load))))
    first = int(contact[0]) if len(contact) else len(load)
    return int(SURELY_FREE * before_touch(first, load, t_ns))
