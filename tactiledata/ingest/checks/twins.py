"""Recordings that hold the same touches: an edited copy of a log, a damaged copy of a bag, one run recorded twice.

Their files differ, so that their digests do not tell. A sensor cannot be in two touches at once: where the trajectories
of one sensor overlap in time between two recordings, these are twins.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from tactiledata.contract.records import Finding
from tactiledata.store.read.reader import Store

ABSOLUTE = 10**18
"""ns, September 2001. Times before it come from a clock that starts with the recording, or count frames."""

Pairs = dict[int, dict[int, int]]


def twins_of_store(store: Store) -> dict[int, Finding]:
    """A finding for each recording of a store that has a twin there, by its row of the table of sources."""
    keys = store.sources(["key"])["key"].to_pylist()
    touches = store.trajectories(["source", "sensor", "start_ns", "end_ns", "parent"]).to_pylist()
    return {row: twin_finding(keys, others) for row, others in sorted(overlaps(touches).items())}


def twin_finding(keys: Sequence[str], others: Mapping[int, int]) -> Finding:
    """What is said of a recording that has twins: ``others`` counts shared trajectories by row, ``keys`` has names."""
    names = [f"{keys[other]} ({count})" for other, count in sorted(others.items())]
    listed = ", ".join(names[:3]) + (f" and {len(names) - 3} more recordings" if names[3:] else "")
    text = (
        f"trajectories of the same sensor at the same time are in other recordings too: {listed}. "
        "One may be an edited or a damaged copy of the other; keep one of them"
    )
    return Finding("recording-twin", "warning", text, count=sum(others.values()))


def overlaps(touches: Iterable[Mapping[str, object]]) -> Pairs:
    """How many trajectories of each source overlap one of another source, by source and other source.

    Parameters
    ----------
    touches : iterable of dict
        ``source``, ``sensor``, ``start_ns``, ``end_ns``, ``parent``. Derived ones, those without a sensor and those on
        a clock that is not absolute are left out. Sensors that nobody names count as one where the times are equal to
        the nanosecond.
    """
    pairs: Pairs = {}
    by_sensor: dict[str, list[tuple[int, int, int]]] = {}
    for touch in touches:
        start, end = int(touch["start_ns"]), int(touch["end_ns"])  # type: ignore[call-overload]
        sensor = str(touch["sensor"])
        if not sensor or touch["parent"] or start < ABSOLUTE or end <= start:
            continue
        place = f"{start}-{end}" if sensor.startswith("unknown-") else sensor
        by_sensor.setdefault(place, []).append((start, end, int(touch["source"])))  # type: ignore[call-overload]
    for intervals in by_sensor.values():
        running: list[tuple[int, int, int]] = []  # number, end, source
        met: set[tuple[int, int, int]] = set()
        for number, (start, end, source) in enumerate(sorted(intervals)):
            running = [one for one in running if one[1] > start]
            for at, _, other in running:
                if other != source:
                    met |= {(number, source, other), (at, other, source)}
            running.append((number, end, source))
        for _, source, other in met:
            counts = pairs.setdefault(source, {})
            counts[other] = counts.get(other, 0) + 1
    return pairs
