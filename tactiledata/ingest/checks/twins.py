"""Recordings that hold the same touches: an edited copy of a log, a damaged copy of a bag, one run recorded twice.

Their files differ, so that their digests do not tell. A sensor cannot be in two touches at once: where the trajectories
of one sensor overlap in time between two recordings, these are twins.
"""

from __future__ import annotations

import shlex
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

from tactiledata.contract.records import Finding
from tactiledata.contract.wording import counted
from tactiledata.errors import TactileDataError
from tactiledata.store.read.flags import flagged_trajectories
from tactiledata.store.read.reader import Store
from tactiledata.store.read.recording_names import recording_names

ABSOLUTE = 10**18
"""ns, September 2001. Times before it come from a clock that starts with the recording, or count frames."""

COLUMNS = ("source", "sensor", "start_ns", "end_ns", "parent")
"""Columns of the table of trajectories that tell whether two trajectories are one touch."""

Pairs = dict[int, dict[int, int]]


def twins_of_store(store: Store) -> dict[int, Finding]:
    """A finding for each recording of a store that has a twin there, by its row of the table of sources.

    Flagged trajectories are left out: somebody chose already which of two copies splits take.
    """
    names, flagged = recording_names(store), flagged_trajectories(store)
    columns = ["uid", "indenter", *COLUMNS]
    touches = [touch for touch in store.trajectories(columns).to_pylist() if touch["uid"] not in flagged]
    differs = _other_indenters(touches)
    found = {}
    for row, others in sorted(overlaps(touches).items()):
        reason = f"a copy of {names[min(others)]}"
        command = shlex.join(["tactiledata", "flag", store.location, names[row], "--reason", reason])
        remedy = f"{differs.get(row, '')}. Splits leave this one out after: {command}"
        found[row] = twin_finding(names, others, remedy)
    return found


def _other_indenters(touches: Sequence[Mapping[str, Any]]) -> dict[int, str]:
    """Say, for each recording, of how many touches a twin names another indenter, and one example."""
    met: dict[int, dict[int, tuple[str, str]]] = {}
    for one, other in _meetings(touches):
        here, there = touches[one]["indenter"], touches[other]["indenter"]
        if here and there and here != there:
            met.setdefault(touches[one]["source"], {})[one] = here, there
    return {
        source: f"; of {counted(len(of_touches), 'trajectory')} the other names another indenter"
        f" ({of_touches[min(of_touches)][0]} here, {of_touches[min(of_touches)][1]} there), and one of them is wrong"
        for source, of_touches in met.items()
    }


def need_touches_once(store: Store, sensor: str | None = None) -> None:
    """Refuse a store in which a touch that is not flagged lies in two recordings.

    A fit would count such a touch twice, and hold one of the two out while it fits the other.

    Parameters
    ----------
    store : Store
    sensor : str, optional
        Name of the only sensor whose touches are asked for; all sensors where ``None``.

    Raises
    ------
    TactileDataError
        Two recordings hold the same touches.
    """
    flagged = flagged_trajectories(store)
    touches = store.trajectories(["uid", *COLUMNS]).to_pylist()
    pairs = overlaps(touch for touch in touches if touch["uid"] not in flagged and sensor in (None, touch["sensor"]))
    if not pairs:
        return
    names = recording_names(store)
    one, others = min(pairs.items())
    copy = names[max(others)]
    command = shlex.join(["tactiledata", "flag", store.location, copy, "--reason", f"a copy of {names[one]}"])
    raise TactileDataError(
        f"{store.location}: {counted(others[max(others)], 'trajectory')} of {copy} at the same time as those of"
        f" {names[one]}, by one sensor: one recording is a copy of the other",
        "each touch once: a fit counts a copy twice, and holds out what it also fits",
        f"Flag one of them: {command}",
    )


def twin_finding(keys: Sequence[str], others: Mapping[int, int], remedy: str = "; keep one of them") -> Finding:
    """What is said of a recording that has twins.

    Parameters
    ----------
    keys : sequence of str
        Names of the recordings.
    others : dict, row of a recording -> int
        How many trajectories it shares with each other one.
    remedy : str
        End of the sentence.
    """
    names = [f"{keys[other]} ({count})" for other, count in sorted(others.items())]
    listed = ", ".join(names[:3]) + (f" and {len(names) - 3} more recordings" if names[3:] else "")
    text = (
        f"trajectories of the same sensor at the same time are in other recordings too: {listed}. "
        f"One may be an edited or a damaged copy of the other{remedy}"
    )
    return Finding("recording-twin", "warning", text, count=sum(others.values()))


def twin_rows(store: Store, rows: Collection[int]) -> list[int]:
    """Rows of the trajectories that are copies, in other recordings, of some of a store; none of these themselves."""
    touches = store.trajectories(COLUMNS).to_pylist()
    met = {other for one, other in _meetings(touches) if one in rows}
    return sorted(met - set(rows))


def overlaps(touches: Iterable[Mapping[str, Any]]) -> Pairs:
    """How many trajectories of each source overlap one of another source, by source and other source.

    Parameters
    ----------
    touches : iterable of dict
        ``source``, ``sensor``, ``start_ns``, ``end_ns``, ``parent``. Derived ones, those without a sensor and those on
        a clock that is not absolute are left out. Sensors that nobody names count as one where the times are equal to
        the nanosecond.
    """
    known = list(touches)
    pairs: Pairs = {}
    for row, other in {(one, known[other]["source"]) for one, other in _meetings(known)}:
        counts = pairs.setdefault(known[row]["source"], {})
        counts[other] = counts.get(other, 0) + 1
    return pairs


def _meetings(touches: Sequence[Mapping[str, Any]]) -> Iterator[tuple[int, int]]:
    """Yield the rows of two touches of different recordings that overlap, both ways round."""
    by_sensor: dict[str, list[tuple[int, int, int]]] = {}
    for row, touch in enumerate(touches):
        start, end, sensor = touch["start_ns"], touch["end_ns"], touch["sensor"]
        if not sensor or touch["parent"] or start < ABSOLUTE or end <= start:
            continue
        place = f"{start}-{end}" if sensor.startswith("unknown-") else sensor
        by_sensor.setdefault(place, []).append((start, end, row))
    for intervals in by_sensor.values():
        running: list[tuple[int, int]] = []  # end, row
        for start, end, row in sorted(intervals):
            running = [one for one in running if one[0] > start]
            for _, other in running:
                if touches[other]["source"] != touches[row]["source"]:
                    yield row, other
                    yield other, row
            running.append((end, row))
