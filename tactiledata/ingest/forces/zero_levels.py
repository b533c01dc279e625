"""Whether a trajectory begins in free air, told by how it ends and by its neighbours.

A reading of 1.9 N may be the zero of a sensor that drifted, or a light contact. A trajectory whose beginning was lost
proves nothing by its first samples, and one that ends at the level of its neighbours and not at its own began pressed.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.contract.records import Finding, Times, Values
from tactiledata.contract.wording import agreeing, counted, listed
from tactiledata.ingest.clocks.witnesses import usual_distance
from tactiledata.ingest.forces.tare_events import Tare, without_steps

LOST = 100_000_000
"""ns. A trajectory whose first samples come later than this after its start has lost its beginning."""

CALM = 0.2
"""N. Two levels of free air differ by less, within one trajectory and between neighbours."""

EDGE = 10
"""Samples at either end that a level is the median of."""


@dataclass(frozen=True)
class Ends:
    """How a trajectory begins and ends.

    Parameters
    ----------
    name : str
    start, stop : int
        Rows.
    begin, end : (6,) N, N m
        Load at either end, as it was read.
    end_as_begin : (6,)
        Load at the end, with the jumps of stated tare events inside taken off.
    is_begin_lost, is_end_lost : bool
        Samples are missing there.
    """

    name: str
    start: int
    stop: int
    begin: Values
    end: Values
    end_as_begin: Values
    is_begin_lost: bool
    is_end_lost: bool

    @property
    def moved(self) -> float:
        """N. Distance of the load at the end from that at the beginning."""
        return _apart(self.end_as_begin, self.begin)


def ends_of(t_ns: Times, load: Values, tares: Sequence[Tare], span: tuple[str, int, int]) -> Ends | None:
    """How a trajectory begins and ends; ``None`` where it has too few samples to tell.

    Parameters
    ----------
    t_ns : (n,) int64
    load : (n, 6) N, N m
    tares : sequence of Tare
    span : name, first and last moment (ns)
    """
    name, start_ns, end_ns = span
    start, stop = (int(row) for row in np.searchsorted(t_ns, [start_ns, end_ns]))
    sound = start + np.flatnonzero(np.isfinite(load[start:stop]).all(axis=1))
    if len(sound) < EDGE:
        return None
    steady = without_steps(load, tares, start, stop)
    allowed = EDGE * usual_distance(t_ns) + LOST
    return Ends(
        name,
        start,
        stop,
        np.median(load[sound[:EDGE]], axis=0),
        np.median(load[sound[-EDGE:]], axis=0),
        np.median(steady[sound[-EDGE:] - start], axis=0),
        bool(t_ns[sound[EDGE - 1]] - start_ns > allowed),
        bool(end_ns - t_ns[sound[-EDGE]] > allowed),
    )


def _apart(one: Values, other: Values) -> float:
    return float(np.linalg.norm((one - other)[:3]))


def pressed_beginnings(ends: Sequence[Ends], tares: Sequence[Tare], threshold: float) -> set[str]:
    """Names of the trajectories that begin in contact, or that may do so because their beginning was lost.

    Parameters
    ----------
    ends : sequence of Ends
        In order of time.
    tares : sequence of Tare
    threshold : float
        N. Change of the force that counts as a touch.
    """
    found = set()
    for number, own in enumerate(ends):
        before = _neighbour(ends, tares, number, True)
        if own.is_begin_lost:
            levels = [level for level in (before, _neighbour(ends, tares, number, False)) if level is not None]
            is_calm = any(_apart(own.begin, level) <= CALM for level in levels)
            if not is_calm and (own.is_end_lost or own.moved > CALM):
                found.add(own.name)
            continue
        if before is None or own.moved <= threshold:
            continue
        if _apart(own.end_as_begin, before) <= threshold < _apart(own.begin, before):
            found.add(own.name)
    return found


def free_beginnings(ends: Sequence[Ends], tares: Sequence[Tare], pressed: set[str]) -> set[str]:
    """Names of the trajectories that begin in free air whatever the rest of the recording reads.

    Two neighbours that both begin and end at one level were in free air there: the sensor was set to zero before or
    after them, and nobody stated it. So was one after them that begins at that level, wherever it ends.

    Parameters
    ----------
    ends, tares
        As for `pressed_beginnings`.
    pressed : set of str
        Names of those that begin in contact.
    """
    found: set[str] = set()
    returning = {own.name for own in ends if _returns(own) and own.name not in pressed}
    for before, after in itertools.pairwise(ends):
        if any(before.start < tare.row <= after.start for tare in tares) or _apart(before.end, after.begin) > CALM:
            continue
        if {before.name, after.name} <= returning:
            found |= {before.name, after.name}
        elif before.name in found & returning and not after.is_begin_lost and after.name not in pressed:
            found.add(after.name)
    return found


def _returns(own: Ends) -> bool:
    """Whether a trajectory was recorded from start to end, and ends at the level at which it begins."""
    return not (own.is_begin_lost or own.is_end_lost) and own.moved <= CALM


def _neighbour(ends: Sequence[Ends], tares: Sequence[Tare], number: int, is_before: bool) -> Values | None:
    """The zero (6,) of the nearest trajectory before or after one, as it is on this side of that trajectory.

    Only one counts whose beginning was recorded, with no stated tare event between the two (or in this one, for the
    one after it).
    """
    own, others = ends[number], ends[:number][::-1] if is_before else ends[number + 1 :]
    for other in others:
        first, last = (other.stop, own.start) if is_before else (own.start + 1, other.start)
        if any(first <= tare.row <= last for tare in tares):
            return None
        if not other.is_begin_lost:
            return other.begin + (other.end - other.end_as_begin) if is_before else other.begin
    return None


def moved_zeros(ends: Sequence[Ends], tares: Sequence[Tare], pressed: set[str], threshold: float) -> list[Ends]:
    """Trajectories inside which the zero moves by more than a touch: where they end, the next one begins.

    Parameters
    ----------
    ends, tares, threshold
        As for `pressed_beginnings`.
    pressed : set of str
        Names of those that begin in contact.
    """
    found = []
    for number, own in enumerate(ends[:-1]):
        after = ends[number + 1]
        if own.name in pressed or after.name in pressed or own.is_end_lost or after.is_begin_lost:
            continue
        if any(own.stop <= tare.row <= after.start for tare in tares):
            continue
        if own.moved > threshold and _apart(own.end, after.begin) <= CALM < _apart(own.end, own.begin):
            found.append(own)
    return found


def moved_findings(moved: Sequence[Ends]) -> list[Finding]:
    """A finding that names the trajectories inside which the zero moves."""
    if not moved:
        return []
    names = listed([own.name for own in moved], 5)
    at_ends = agreeing(len(moved), "it ends, and the next one begins", "they end, and the next ones begin")
    text = (
        f"wrench: the zero moves by up to {max(own.moved for own in moved):.2f} N inside "
        f"{counted(len(moved), 'trajectory')} ({names}): {at_ends}, at another reading than at the "
        "beginning. No tare is stated there, so forces after it are off by as much; state the moments in wrench.tare_ns"
    )
    return [Finding("zero-moved", "warning", text, "wrench", count=len(moved))]
