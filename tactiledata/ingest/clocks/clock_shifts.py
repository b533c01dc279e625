"""Streams whose whole clock is off: they begin and end later (or earlier) than another one by the same time.

A stream that begins late, ends early or pauses lasts shorter than the others. One that lasts as long as another, and is
shifted against it so that touches lie outside it, was recorded with them by a clock that is off.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.records import Finding, Recording, Times
from tactiledata.ingest.clocks.clock_steps import judge_steps
from tactiledata.ingest.clocks.witnesses import AGREE, SIGNAL, pauses_of, witness_of

LEAST_SHIFT = 1_000_000_000
"""ns. Recorders of several streams start and stop them one after another within less."""
FAR = 500_000_000
"""ns. An image that names a trajectory lies at most this far outside its interval: people end intervals by hand."""
MOST_PAUSES = 2
"""Long pauses of a camera that films all the time; one that is triggered by steps has one between any two touches."""

KEPT_WITHOUT = "images were kept without forces and poses, which would be those of another moment"

Span = tuple[int, int]
"""First and last moment, ns."""


@dataclass(frozen=True)
class Shift:
    """The time (ns) by which a stream is late, and the name of the stream that shows it."""

    late_ns: int
    against: str


def shift_of(name: str, spans: Mapping[str, Span], touches: Span | None) -> Shift | None:
    """The shift of a stream against one that lasts as long and covers all touches; ``None`` where none is certain.

    Parameters
    ----------
    name : str
    spans : dict, stream -> first and last moment
        The stream itself, too.
    touches : (int, int), optional
        First moment of the first and last moment of the last touch.
    """
    if touches is None or name not in spans or _covers(spans[name], touches):
        return None
    start, end = spans[name]
    for other, span in spans.items():
        late, ends_late = start - span[0], end - span[1]
        is_same_length = abs(late - ends_late) <= AGREE
        if other != name and is_same_length and abs(late) >= LEAST_SHIFT and _covers(span, touches):
            return Shift((late + ends_late) // 2, other)
    return None


def _covers(span: Span, touches: Span) -> bool:
    return span[0] <= touches[0] + AGREE and span[1] >= touches[1] - AGREE


def span_of(t_ns: Times) -> Span:
    """First and last of some moments."""
    return int(t_ns.min()), int(t_ns.max())


def touched_span(recording: Recording, cameras: Mapping[str, Times]) -> Span | None:
    """Return the span from the first to the last trajectory that a recording names, else from its first image to its
    last.
    """
    if recording.trajectories:
        starts = [trajectory.start_ns for trajectory in recording.trajectories]
        return min(starts), max(trajectory.end_ns for trajectory in recording.trajectories)
    filmed = [span_of(t_ns) for t_ns in cameras.values() if len(t_ns)]
    return (min(start for start, _ in filmed), max(end for _, end in filmed)) if filmed else None


def shift_finding(name: str, shift: Shift, t_ns: Times, stated_ns: int, clock: str, lost: str) -> Finding:
    """What is said of a stream that is shifted as a whole.

    Parameters
    ----------
    name : str
    shift : Shift
    t_ns : (n,) int64
        As the stream has them.
    stated_ns : int
        The offset that the recording states for it.
    clock : str
        Its name among the ``clocks`` of a description.
    lost : str
        What was done with its samples, in words.
    """
    text = (
        f"{name}: begins and ends {abs(shift.late_ns) / 1e9:.3f} s {'later' if shift.late_ns > 0 else 'earlier'} than "
        f"{shift.against}, which lasts as long and covers all touches: its clock is off; its {len(t_ns)} {lost}. Mend "
        f"its times, or state `clocks: {{{clock}: {{offset_ns: {stated_ns - shift.late_ns}}}}}`, and ingest again"
    )
    start, end = (moment - shift.late_ns for moment in span_of(t_ns))
    return Finding("clock-apart", "damage", text, name, start_ns=start, end_ns=end, count=len(t_ns))


@dataclass(frozen=True)
class DisplacedFrames:
    """A mask (n,) of images whose time is off, and the findings on them."""

    is_off: NDArray[np.bool_]
    findings: tuple[Finding, ...]


def judge_frames(
    recording: Recording,
    cameras: Mapping[str, NDArray[np.int64]],
    t_ns: Times,
    crc: Times,
    signals: Mapping[str, Times],
) -> DisplacedFrames:
    """Images whose clock jumped or is off as a whole, judged by the signals and by the trajectories that they name.

    Parameters
    ----------
    recording : Recording
    cameras : dict, camera -> (m,) rows of its images
    t_ns : (n,) int64
        Host times of the images, in the order of the recording.
    crc : (n,) int64
        Checksums of the images: copies have the same.
    signals : dict, name -> (k,) int64
        Host times of each signal's samples that can be believed.
    """
    is_off = np.zeros(len(t_ns), dtype=bool)
    findings: list[Finding] = []
    spans = {name: span_of(times) for name, times in signals.items() if len(times) > 1}
    witnesses = [witness_of(SIGNAL, signals[name]) for name in spans]
    touches = touched_span(recording, {})
    for camera, rows in cameras.items():
        if len(rows) < 2:
            continue
        if witnesses:
            films_on = len(pauses_of(t_ns[rows])) <= MOST_PAUSES
            own = crc[rows, None].astype(np.float64)
            judged = judge_steps(camera, t_ns[rows], own, witnesses, KEPT_WITHOUT, pauses=films_on)
            is_off[rows[~judged.kept]] = True
            findings.extend(finding for finding in judged.findings if finding.code == "clock-jump")
        kept = rows[~is_off[rows]]
        shift = shift_of(camera, {**spans, camera: span_of(t_ns[kept])}, touches) if len(kept) else None
        if shift is not None:
            is_off[rows] = True
            stated = recording.description.stated_clock_offset("frames") or 0
            findings.append(shift_finding(camera, shift, t_ns[kept], stated, "frames", KEPT_WITHOUT))
    return DisplacedFrames(is_off, tuple(findings))


def named_elsewhere(recording: Recording, t_ns: Times, named: Sequence[str]) -> DisplacedFrames:
    """Images that lie far outside the trajectory that they name: their time or the trajectory's is wrong.

    Parameters
    ----------
    recording : Recording
    t_ns : (n,) int64
    named : (n,) names, empty where none is named
    """
    names = np.array(named, dtype=object)
    unknown = np.iinfo(np.int64).max
    beyond = np.full(len(t_ns), unknown)
    for trajectory in recording.trajectories:  # several may have one name
        rows = names == trajectory.name
        outside = np.maximum(trajectory.start_ns - t_ns[rows], t_ns[rows] - trajectory.end_ns)
        beyond[rows] = np.minimum(beyond[rows], outside)
    is_off = (beyond > FAR) & (beyond < unknown)
    if not is_off.any():
        return DisplacedFrames(is_off, ())
    count = int(is_off.sum())
    text = (
        f"frames: {count} of {len(t_ns)} images lie up to {beyond[is_off].max() / 1e9:.3f} s outside the trajectories "
        f"that they name (for example of {names[is_off][0]!r}): their times or the trajectories' are wrong. They were "
        "kept without forces and poses. Mend the times, or state `clocks: {frames: {offset_ns: ...}}`, and ingest again"
    )
    return DisplacedFrames(is_off, (Finding("frame-elsewhere", "damage", text, "frames", count=count),))
