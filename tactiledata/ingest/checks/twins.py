"""Recordings that hold the same touches: an edited copy of a log, a damaged copy of a bag, one run recorded twice.

Their files differ, so that their digests do not tell. A sensor cannot be in two touches at once: where the trajectories
of one sensor overlap in time between two recordings, these are twins. No camera takes the same bytes twice: where
trajectories of two recordings share most of their images, these are twins whatever their times.
"""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from tactiledata.contract.records import Finding
from tactiledata.contract.wording import agreeing, counted, listed
from tactiledata.errors import TactileDataError
from tactiledata.ingest.checks.shared_images import IMAGE_COLUMNS, touches_of_same_images
from tactiledata.store.read.flags import COPY, flagged_trajectories, is_of_copy
from tactiledata.store.read.named_trajectories import full_names
from tactiledata.store.read.reader import Store
from tactiledata.store.read.recording_names import recording_names

ABSOLUTE = 10**18
"""ns, September 2001. Times before it come from a clock that starts with the recording, or count frames."""

COLUMNS = ("source", "sensor", "start_ns", "end_ns", "parent")
"""Columns of the table of trajectories that tell whether two trajectories are one touch."""

MOST_SAID = 4
"""Recordings that an error names."""

Pairs = dict[int, dict[int, int]]


def twins_of_store(store: Store) -> dict[int, Finding]:
    """A finding for each recording of a store that has a twin there, by its row of the table of sources.

    What is flagged as a copy is left out: somebody chose already which of two copies splits take. A touch that is
    flagged as bad is bad in every copy.
    """
    touches = _touches(store)
    pairs = _pairs(store, touches)
    if not pairs:
        return {}
    command = _FlagCommand(store, touches)
    differs, bad = _other_indenters(touches, pairs), _flagged_elsewhere(touches, pairs)
    of_source: dict[int, list[tuple[int, int]]] = {}
    for one, other in pairs:
        of_source.setdefault(touches[one]["source"], []).append((one, other))
    found = {}
    for row, others in sorted(_counted(touches, pairs).items()):
        first = min(others)
        here = [(one, other) for one, other in of_source[row] if not touches[one]["flag"]]
        copies = [one for one, other in here if touches[other]["source"] == first or touches[other]["flag"]]
        remedy = f"{differs.get(row, '')}{bad.get(row, '')}"
        if copies:
            remedy += f". Splits leave this one out after: {command.of(copies, command.recordings[first])}"
        found[row] = twin_finding(command.recordings, others, remedy or "; those here are flagged")
    return found


def _touches(store: Store) -> list[dict[str, Any]]:
    """The trajectories of a store, each with what tells whether it is another, and the reason of its flag."""
    flagged = flagged_trajectories(store)
    touches = store.trajectories(["uid", "indenter", *COLUMNS]).to_pylist()
    return [{**touch, "flag": flagged[touch["uid"]].reason if touch["uid"] in flagged else ""} for touch in touches]


def _pairs(store: Store, touches: Sequence[Mapping[str, Any]]) -> list[tuple[int, int]]:
    """Rows of touches of two recordings that are one touch, both ways round.

    Pairs of which one is flagged as a copy, or both as bad, are left out: nothing is to be done about them.
    """
    source = np.array([touch["source"] for touch in touches], np.int64)
    alike = touches_of_same_images(store.frames(list(IMAGE_COLUMNS)), source)
    met = {*_meetings(touches), *(pair for pair in alike if not any(touches[row]["parent"] for row in pair))}
    flags = {pair: [touches[row].get("flag", "") for row in pair] for pair in met}
    return sorted(pair for pair, said in flags.items() if not all(said) and not any(map(is_of_copy, said)))


def _flagged_elsewhere(touches: Sequence[Mapping[str, Any]], pairs: Iterable[tuple[int, int]]) -> dict[int, str]:
    """Say, for each recording, of how many touches that are not flagged a copy is flagged as bad, and one reason."""
    met: dict[int, dict[int, str]] = {}
    for one, other in pairs:
        if touches[other]["flag"]:
            met.setdefault(touches[one]["source"], {})[one] = touches[other]["flag"]
    return {
        source: f"; {counted(len(of_touches), 'trajectory')} of it {agreeing(len(of_touches), 'is', 'are')} flagged"
        f" there ({of_touches[min(of_touches)]}) and not here"
        for source, of_touches in met.items()
    }


class _FlagCommand:
    """Commands that flag touches: by the names of recordings where these are all that they hold, else by their own.

    Parameters
    ----------
    store : Store
    touches : sequence of dict
        All of its trajectories, as `_touches` gives them.
    """

    def __init__(self, store: Store, touches: Sequence[Mapping[str, Any]]) -> None:
        self.recordings = recording_names(store)
        self._location, self._touches, self._full = store.location, touches, full_names(store)
        self._free: dict[int, set[int]] = {}
        for row, touch in enumerate(touches):
            if not touch["flag"]:
                self._free.setdefault(touch["source"], set()).add(row)

    def of(self, copies: Collection[int], origin: str) -> str:
        """Return the command for the trajectories of these rows, which are copies of a recording of this name."""
        wanted = set(copies)
        said: dict[str, None] = {}  # each name once, in order
        for row in sorted(wanted):
            source = self._touches[row]["source"]
            said[self.recordings[source] if self._free[source] <= wanted else self._full[row]] = None
        return shlex.join(["tactiledata", "flag", self._location, *said, "--reason", f"{COPY} {origin}"])


def _other_indenters(touches: Sequence[Mapping[str, Any]], pairs: Iterable[tuple[int, int]]) -> dict[int, str]:
    """Say, for each recording, of how many touches a twin names another indenter, and one example."""
    met: dict[int, dict[int, tuple[str, str]]] = {}
    for one, other in pairs:
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
    touches = _touches(store)
    pairs = [pair for pair in _pairs(store, touches) if sensor in (None, *(touches[row]["sensor"] for row in pair))]
    if not pairs:
        return
    command, source = _FlagCommand(store, touches), [touch["source"] for touch in touches]
    names = command.recordings
    # of each pair the one that is not flagged, else the one that came later
    copies = {}
    for pair in pairs:
        first, last = sorted(pair, key=lambda row: (not touches[row]["flag"], source[row]))
        copies[last] = first
    original = {source[copy]: source[one] for copy, one in copies.items()}
    counts = Counter(source[copy] for copy in copies)
    bad = _flagged_elsewhere(touches, pairs)
    said = [
        f"{counted(counts[row], 'trajectory')} of {names[row]} as in {names[original[row]]}{bad.get(row, '')}"
        for row in sorted(counts)
    ]
    is_one = len(said) == 1
    origin = names[next(iter(original.values()))] if is_one else "another recording"
    raise TactileDataError(
        f"{store.location}: {listed(said, MOST_SAID)}, by the same sensor at the same time, or with the same images: "
        f"{'this recording is a copy' if is_one else 'these recordings are copies'}",
        "each touch once, and none whose copy is flagged: a fit counts a copy twice, and holds out what it also fits",
        f"Flag {'it' if is_one else 'them'}: {command.of(copies, origin)}",
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
    more = f" and {len(names) - 3} more recordings" if names[3:] else ""
    text = (
        f"trajectories of the same sensor at the same time, or with the same images, are in other recordings too: "
        f"{', '.join(names[:3])}{more}. One may be an edited or a damaged copy of the other{remedy}"
    )
    return Finding("recording-twin", "warning", text, count=sum(others.values()))


def twin_rows(store: Store, rows: Collection[int]) -> list[int]:
    """Rows of the trajectories that are copies, in other recordings, of some of a store; none of these themselves."""
    touches = store.trajectories(COLUMNS).to_pylist()
    met = {other for one, other in _pairs(store, touches) if one in rows}
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
    return _counted(known, _meetings(known))


def _counted(touches: Sequence[Mapping[str, Any]], pairs: Iterable[tuple[int, int]]) -> Pairs:
    """How many touches of each source are paired with one of another, by source and other source."""
    found: Pairs = {}
    for row, other in {(one, touches[other]["source"]) for one, other in pairs}:
        counts = found.setdefault(touches[row]["source"], {})
        counts[other] = counts.get(other, 0) + 1
    return found


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
