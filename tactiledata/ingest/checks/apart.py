"""Streams of one recording that do not belong together: on clocks that never meet, or filed under another sensor."""

from __future__ import annotations

import numpy as np

from tactiledata.contract.records import Finding
from tactiledata.contract.take import Take


def apart_findings(take: Take) -> list[Finding]:
    """Findings on signals that lie before or after all trajectories, and on images that the wrong serial keeps out."""
    if not take.trajectories.num_rows:
        return []
    return [*_elsewhere(take), *_other_sensor(take)]


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
