"""Streams of one recording that do not meet: other clocks, a recorder that stopped, images under another sensor."""

from __future__ import annotations

import numpy as np

from tactiledata.contract.records import Finding
from tactiledata.contract.take import Take
from tactiledata.contract.wording import listed
from tactiledata.ingest.clocks.witnesses import usual_distance

LEAST_LACK = 500_000_000
"""ns. A trajectory may last so much longer than a signal, and ten of its samples, before something is said."""
MOST_NAMED = 5
"""Trajectories that a sentence names."""


def apart_findings(take: Take) -> list[Finding]:
    """Findings on signals that miss all or some trajectories, and on images that the wrong serial keeps out."""
    if not take.trajectories.num_rows:
        return []
    return [*_elsewhere(take), *_incomplete(take), *_other_sensor(take)]


def _elsewhere(take: Take) -> list[Finding]:
    start, end = take.trajectories["start_ns"].to_numpy().min(), take.trajectories["end_ns"].to_numpy().max()
    found = []
    for name, signal in sorted(take.signals.items()):
        if "derived_from" in signal.attributes or not len(signal.t_ns):
            continue
        late, early = int(signal.t_ns[0] - end), int(start - signal.t_ns[-1])
        if max(late, early) < 0:
            continue
        where = f"{late / 1e9:.6g} s after" if late >= 0 else f"{early / 1e9:.6g} s before"
        text = (
            f"{name}: all {len(signal.t_ns)} samples lie {where} the trajectories, so that no image has a value of it; "
            "another clock, another time zone, or times that are no nanoseconds?"
        )
        found.append(Finding("signal-elsewhere", "warning", text, name, count=len(signal.t_ns)))
    return found


def _incomplete(take: Take) -> list[Finding]:
    """Trajectories of which a signal that meets others has no sample at the beginning or at the end."""
    start, end = (take.trajectories[name].to_numpy() for name in ("start_ns", "end_ns"))
    names = take.trajectories["trajectory"].to_pylist()
    streams = [take.frames["t_ns"].to_numpy(), *(signal.t_ns for signal in take.signals.values())]
    recorded = [times for times in streams if len(times)]
    if not recorded:
        return []
    begins, ends = min(times.min() for times in recorded), max(times.max() for times in recorded)
    # a touch that was found has a margin, which may reach beyond the recording
    is_found = np.array(take.trajectories["segmented"].to_pylist(), dtype=object) != "log"
    start = np.where(is_found, np.maximum(start, begins), start)
    end = np.where(is_found, np.minimum(end, ends), end)
    found = []
    for name, signal in sorted(take.signals.items()):
        if "derived_from" in signal.attributes or not len(signal.t_ns):
            continue
        first, last = signal.t_ns[0], signal.t_ns[-1]
        if first >= end.max() or last <= start.min():
            continue
        lack = np.maximum(np.minimum(first, end) - start, end - np.maximum(last, start))
        rows = np.flatnonzero(lack > max(LEAST_LACK, 10 * usual_distance(signal.t_ns)))
        if not len(rows):
            continue
        named = listed([names[row] for row in rows], MOST_NAMED)
        text = (
            f"{name} begins or ends inside or beside {len(rows)} of {len(names)} trajectories ({named}), up to "
            f"{lack.max() / 1e9:.2f} s of them: no image there has a value of it. Did its recorder stop, or start late?"
        )
        found.append(Finding("signal-incomplete", "warning", text, name, count=len(rows)))
    return found


def _other_sensor(take: Take) -> list[Finding]:
    """Trajectories without images in whose time there are images of another sensor that belong to no trajectory."""
    outside = take.frames["trajectory"].to_numpy() < 0
    t_ns = take.frames["t_ns"].to_numpy()[outside]
    names = np.array(take.frames["sensor"].to_pylist(), dtype=object)[outside]
    found = []
    for row in take.trajectories.to_pylist():
        if row["frame_start"] < row["frame_stop"]:
            continue
        inside = (t_ns >= row["start_ns"]) & (t_ns < row["end_ns"]) & (names != row["sensor"])
        if inside.any():
            found.append((row, sorted(set(names[inside])), int(inside.sum())))
    if not found:
        return []
    row, others, _ = found[0]
    n_images = sum(count for _, _, count in found)
    text = (
        f"{n_images} images lie in the time of {len(found)} trajectories without images, under another sensor "
        f"(for example {', '.join(others)} in {row['trajectory']!r} of {row['sensor'] or 'no sensor'}); "
        "they belong to none, and no split takes them"
    )
    return [Finding("images-of-another-sensor", "warning", text, count=n_images)]
