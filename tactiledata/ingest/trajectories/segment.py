"""Trajectories, where a recording names none: from free air before a contact to free air after it."""

from __future__ import annotations

import numpy as np

from tactiledata.contract.records import Finding, Times, Trajectory
from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.forces.onset import touch_threshold, touching

MARGIN = 1_000_000_000
"""ns of free air kept on either side of a contact, or half the way to the neighbouring one."""

MIN_CONTACT = 50_000_000
"""ns. A shorter contact is a knock or a spike, not a touch."""

MERGE = 300_000_000
"""ns. Two contacts closer than this are one touch that lost contact for a moment."""


def segment_by_contact(
    contact_wrench: StoredSignal, noise: float, sensor: str
) -> tuple[tuple[Trajectory, ...], Finding | None]:
    """Return trajectories ``touch-0000``, ``touch-0001``… of a recording, and a finding on how it begins.

    They go by contact onset and release. A force that is there at the first sample and gone within `MERGE` is none: no
    touch begins so. The sensor was set to zero just after the recorder was started, or a touch just ended; the finding
    says so, and is ``None`` where the recording begins otherwise.

    Parameters
    ----------
    contact_wrench : StoredSignal
        Zero and tool weight taken off.
    noise : float
        N, one component in free air.
    sensor : str
        The recording's sensor, empty where it is not known.
    """
    spans = contact_spans(contact_wrench.t_ns, np.linalg.norm(contact_wrench.values[:, :3], axis=1), noise)
    finding = None
    if _is_beginning(contact_wrench, spans):
        finding = _beginning(*spans.pop(0))
    trajectories = []
    for number, (start, end) in enumerate(spans):
        before = MARGIN if number == 0 else min(MARGIN, (start - spans[number - 1][1]) // 2)
        after = MARGIN if number == len(spans) - 1 else min(MARGIN, (spans[number + 1][0] - end) // 2)
        trajectories.append(Trajectory(f"touch-{number:04d}", int(start - before), int(end + after), sensor))
    return tuple(trajectories), finding


def _beginning(start: int, end: int) -> Finding:
    """Return what is said of a force with which a recording begins and which is gone at once."""
    text = (
        f"wrench: a force at the first sample is gone after {(end - start) / 1e9:.2f} s. Was the sensor set to zero "
        "then, or did a touch end? It was taken for no touch"
    )
    return Finding("begins-under-force", "warning", text, "wrench", start_ns=start, end_ns=end)


def _is_beginning(contact_wrench: StoredSignal, spans: list[tuple[int, int]]) -> bool:
    """Whether the first contact is there at the first sample, and shorter than a pause that joins two contacts."""
    return bool(spans) and spans[0][0] == contact_wrench.t_ns[0] and spans[0][1] - spans[0][0] < MERGE


def contact_spans(t_ns: Times, force: np.ndarray, noise: float) -> list[tuple[int, int]]:
    """Contacts as (onset, release) times, ns; knocks left out, flickers joined.

    Parameters
    ----------
    t_ns : (n,) int64
    force : (n,) N
        Norm of the contact force; samples that are not finite count as no contact.
    noise : float
        N, one component.
    """
    contact = touching(np.nan_to_num(force, nan=0.0), touch_threshold(noise))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], contact.astype(np.int8), [0]])))
    spans = [(int(t_ns[start]), int(t_ns[stop - 1])) for start, stop in zip(edges[::2], edges[1::2], strict=True)]
    joined: list[tuple[int, int]] = []
    for start, end in spans:
        if joined and start - joined[-1][1] < MERGE:
            joined[-1] = (joined[-1][0], end)
        else:
            joined.append((start, end))
    return [(start, end) for start, end in joined if end - start >= MIN_CONTACT]


def whole_recording(start_ns: int, end_ns: int, sensor: str) -> tuple[tuple[Trajectory, ...], Finding]:
    """Return one trajectory over a whole recording without names and forces, and a finding that says so.

    Parameters
    ----------
    start_ns, end_ns : int, ns
        Host times of the first and the last moment of the recording.
    sensor : str
        Serial of the sensor; empty where it is not known.
    """
    finding = Finding(
        "no-segmentation",
        "warning",
        "the recording names no trajectories and holds no wrench to find contacts by; all of it is one trajectory",
        start_ns=start_ns,
        end_ns=end_ns,
    )
    return (Trajectory("whole-recording", start_ns, end_ns + 1, sensor),), finding
