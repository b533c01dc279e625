"""Stated tare events, as the readings show them: where the zero jumps, by how much, and to what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.records import Finding, Times, Values

LATENCY = 100_000_000
"""ns. The reading jumps at most this far from the stated moment: a service call and a queue lie between the two."""

BESIDE = 10
"""Samples on either side that the jump is measured with."""

CLEAR = 6.0
"""Standard deviations of one component's noise, times the root of 3: a jump of the reading that is no noise."""
DOUBTFUL, DOUBTFUL_SHARE = 3, 0.2
"""Events after which the sensor does not read zero, and their share, from which on the whole list is doubted."""
LONGEST_AGO = 86_400_000_000_000
"""ns, a day. A tare event farther from a recording is not its own, or in another unit."""
UNITS = {"seconds": 10**9, "milliseconds": 10**6, "microseconds": 10**3}
"""Nanoseconds in other units that people state moments in."""
PAUSE = 250_000_000
"""ns. Over a longer pause between two samples the zero may have changed unseen."""


@dataclass(frozen=True)
class Tare:
    """One stated tare event.

    Parameters
    ----------
    row : int
        The first sample that is read with the new zero; 0 where the event lies before the recording.
    zero : (6,) N, N m
        The load where the reading is zero: minus the tool's weight, where that is taken off.
    step : (6,) N, N m
        By how much the load jumps there, whatever pressed.
    """

    row: int
    zero: Values
    step: Values


def locate_tares(
    t_ns: Times, load: Values, tare_ns: Sequence[int], zeros: Values, noise: float
) -> tuple[list[Tare], list[int]]:
    """Stated tare events that the readings bear out, in order of time, and the moments (ns) of those they contradict.

    An event after the last sample says nothing about the recording and is in neither list.

    Parameters
    ----------
    t_ns : (n,) int64
    load : (n, 6) N, N m
    tare_ns : sequence of int
        Stated moments, host clock.
    zeros : (len(tare_ns), 6) N, N m
        The load that a reading of zero is at each of them.
    noise : float
        N, one component.
    """
    ordered = [
        (int(tare_ns[row]), zeros[row]) for row in np.argsort(np.asarray(tare_ns, dtype=np.int64), kind="stable")
    ]
    tares, contradicted, n_inside = _located(t_ns, load, ordered, noise, False)
    if len(contradicted) >= DOUBTFUL and len(contradicted) > DOUBTFUL_SHARE * n_inside:
        # of a list that is wrong this often, only what the reading shows by itself is believed
        tares, contradicted, _ = _located(t_ns, load, ordered, noise, True)
    return tares, contradicted


def _located(
    t_ns: Times, load: Values, ordered: Sequence[tuple[int, Values]], noise: float, is_doubtful: bool
) -> tuple[list[Tare], list[int], int]:
    """Events as `locate_tares` gives them, and how many lie inside; where doubtful, only those with a visible jump."""
    tares: list[Tare] = []
    contradicted: list[int] = []
    sound = np.flatnonzero(np.isfinite(load).all(axis=1))
    times, rows = t_ns[sound], load[sound]
    least = n_inside = 0
    for moment, zero in ordered:
        place = int(np.searchsorted(times, moment))
        if place == len(times):
            continue
        if place == 0:
            tares.append(Tare(0, zero, np.zeros(6)))
            continue
        n_inside += 1
        place = max(_place_of_jump(times, rows, moment, zero, noise), least + 1)
        if place >= len(times):
            continue
        if not _reads_zero(times, rows, place, moment, zero, noise):
            contradicted.append(moment)
            continue
        start, stop = _without_pause(times, max(least, place - BESIDE), place, min(place + BESIDE, len(times)))
        step = _step(times, rows, start, place, stop)
        if is_doubtful and np.linalg.norm(step[:3]) <= CLEAR * noise * np.sqrt(3):
            contradicted.append(moment)
            continue
        tares.append(Tare(int(sound[place]), zero, step))
        least = place
    return tares, contradicted, n_inside


def tares_near(t_ns: Times, tare_ns: Sequence[int]) -> tuple[NDArray[np.bool_], list[Finding]]:
    """Return a mask (k,) of stated moments that lie within a day of a recording, and a finding on the others.

    Parameters
    ----------
    t_ns : (n,) int64
    tare_ns : sequence of int
    """
    if not len(t_ns) or not len(tare_ns):
        return np.ones(len(tare_ns), dtype=bool), []
    start, end = int(t_ns[0]) - LONGEST_AGO, int(t_ns[-1]) + LONGEST_AGO
    is_near = np.array([start <= moment <= end for moment in tare_ns])
    if is_near.all():
        return is_near, []
    far = [moment for moment, near in zip(tare_ns, is_near, strict=True) if not near]
    unit = next((name for name, factor in UNITS.items() if all(start <= moment * factor <= end for moment in far)), "")
    text = (
        f"wrench: {len(far)} stated tare events lie more than a day from the recording (for example {far[0]}, where "
        f"the wrench begins at {int(t_ns[0])}); they were not used. wrench.tare_ns is in nanoseconds of the host clock "
        f"since 1970{f'; these look like {unit}' if unit else ''}. Mend them, or leave out those of other recordings"
    )
    return is_near, [Finding("tare-elsewhere", "warning", text, "wrench", count=len(far))]


def _place_of_jump(times: Times, rows: Values, moment: int, zero: Values, noise: float) -> int:
    """The row at which the load comes nearer to its zero than by noise; the first after the moment where none does."""
    first = max(int(np.searchsorted(times, moment - LATENCY)), 1)
    last = int(np.searchsorted(times, moment + LATENCY, side="right"))
    off = np.linalg.norm((rows[first - 1 : last] - zero)[:, :3], axis=1)
    nearer = off[:-1] - off[1:]
    if nearer.max(initial=0.0) <= CLEAR * noise * np.sqrt(3):
        return int(np.searchsorted(times, moment))
    return first + int(np.argmax(nearer))


def _reads_zero(times: Times, rows: Values, place: int, moment: int, zero: Values, noise: float) -> bool:
    """Whether the load is at its zero near the moment; nobody knows where no sample is near."""
    near = np.flatnonzero(times[place:] <= max(moment, int(times[place - 1])) + LATENCY)
    if not len(near) or times[place] - times[place - 1] > LATENCY:
        return True
    off = np.linalg.norm((rows[place + near] - zero)[:, :3], axis=1)
    return bool(off.min() <= max(0.5, CLEAR * noise * np.sqrt(3)))


def _without_pause(times: Times, start: int, place: int, stop: int) -> tuple[int, int]:
    """Return the part of rows [start, stop) around a row in which no two samples lie farther apart than `PAUSE`.

    The rows on either side of the place belong to it however far apart they are: there the load jumps.
    """
    pauses = np.flatnonzero(np.diff(times[start:stop]) > PAUSE) + start + 1
    before, after = pauses[pauses < place], pauses[pauses > place]
    return int(before[-1]) if len(before) else start, int(after[0]) if len(after) else stop


def _step(times: Times, rows: Values, start: int, place: int, stop: int) -> Values:
    """Jump (6,) at a row: least squares of a line with a step there, so that a press on the way is no part of it."""
    seconds = (times[start:stop] - times[place]) / 1e9
    after = (np.arange(start, stop) >= place).astype(np.float64)
    columns = [np.ones_like(after), after]
    if place - start > 2 and stop - place > 2:
        columns.append(seconds)
    solution = np.linalg.lstsq(np.stack(columns, axis=1), rows[start:stop], rcond=None)[0]
    return np.asarray(solution[1])


def without_steps(load: Values, tares: Sequence[Tare], start: int, stop: int) -> Values:
    """Loads of rows [start, stop), with the jumps of the tare events among them taken off: one zero for all.

    Parameters
    ----------
    load : (n, 6)
    tares : sequence of Tare
    start, stop : int
    """
    steady = load[start:stop].copy()
    for tare in tares:
        if start < tare.row < stop:
            steady[tare.row - start :] -= tare.step
    return steady


def contradicted_findings(moments: Sequence[int]) -> list[Finding]:
    """A finding on stated tare events after which the sensor does not read zero."""
    if not moments:
        return []
    text = (
        f"wrench: {len(moments)} stated tare events are not seen: the reading is not zero within "
        f"{LATENCY / 1e9:g} s of them, or (where many are not) does not jump there; they were not used. Mend "
        "wrench.tare_ns (ns of the host clock), or the clock of the wrench"
    )
    first, last = min(moments), max(moments)
    return [Finding("tare-not-seen", "warning", text, "wrench", start_ns=first, end_ns=last, count=len(moments))]
