"""What is said of the zeros that trajectories were given: begun in contact, far from the usual reading, or drifting."""

from __future__ import annotations

import numpy as np

from tactiledata.contract.records import Finding
from tactiledata.contract.wording import agreeing, counted, listed

DRIFT_WORTH_SAYING = 0.2
"""N. Range of the zeros of one recording's trajectories, from which on it is reported."""


def _names(off: list[tuple[str, float]]) -> str:
    """The names of the first trajectories."""
    return listed([name for name, _ in off], 5)


def pressed_findings(missed: list[tuple[str, float]]) -> list[Finding]:
    """A warning of trajectories that do not begin in free air, with how far they begin off the zero that they got.

    No damage: a touch that begins pressed is sound, and one touch alone cannot tell it from a zero that somebody moved.

    Parameters
    ----------
    missed : list of (str, float)
        Name of each trajectory and how far it begins off its zero, N; NaN where no reading of it is whole.
    """
    if not missed:
        return []
    seen = [(name, away) for name, away in missed if np.isfinite(away)]
    unseen = [(name, away) for name, away in missed if not np.isfinite(away)]
    parts, off = [], ""
    if seen:
        do = agreeing(len(seen), "does", "do")
        parts.append(f"{counted(len(seen), 'trajectory')} {do} not begin in free air ({_names(seen)})")
        they_begin = agreeing(len(seen), "It begins", "They begin up to")
        off = (
            f" {they_begin} {max(away for _, away in seen):.2f} N off it: if nothing was touched then, "
            f"{agreeing(len(seen), 'its', 'their')} forces are off by as much."
        )
    if unseen:
        parts.append(
            f"free air cannot be seen in {counted(len(unseen), 'trajectory')} ({_names(unseen)}) without a whole "
            "reading: each is NaN, or has no pose by which the tool's weight is taken off"
        )
    text = (
        f"wrench: {'; '.join(parts)}; the nearest zero that is known was taken.{off} "
        "State tares in wrench.tare_ns, or begin in free air"
    )
    return [Finding("no-free-air", "warning", text, "wrench", count=len(missed))]


def under_load_findings(events: list[tuple[int, float]]) -> list[Finding]:
    """A warning of stated tare events at which something seems to press, in a recording that names no trajectories.

    Whether a gel is pressed or the zero jumped cannot be told where the reading stays what it is until the event.

    Parameters
    ----------
    events : list of (int, float)
        Time of each event, ns, and the force that was taken for one of a contact, N.
    """
    if not events:
        return []
    largest = max(force for _, force in events)
    text = (
        f"wrench: at {counted(len(events), 'stated tare event')} (the first at {events[0][0]} ns) something presses "
        f"with up to {largest:.2f} N: the reading rose within seconds and stayed until then, so the zero after "
        f"{agreeing(len(events), 'it', 'them')} keeps that force. If nothing was touched, the sensor's zero had jumped "
        "and forces after it are off by as much: name the trajectories, or tare in free air"
    )
    return [Finding("tare-under-load", "warning", text, "wrench", start_ns=events[0][0], count=len(events))]


def trusted_findings(trusted: list[tuple[str, float]]) -> list[Finding]:
    """A warning of trajectories that begin and end far from the usual reading, and whose zero was still believed.

    Parameters
    ----------
    trusted : list of (str, float)
        Name of each trajectory and how far it begins from the usual reading, N.
    """
    if not trusted:
        return []
    begin = agreeing(len(trusted), "begins", "begin up to")
    text = (
        f"wrench: {counted(len(trusted), 'trajectory')} ({_names(trusted)}) {begin} "
        f"{max(away for _, away in trusted):.2f} N "
        "from what the sensor reads most of the time, and there, too, is the end: taken as free air after a tare that "
        "nobody stated. If something was pressed all the time, the forces are too small by as much. State tares in "
        "wrench.tare_ns"
    )
    return [Finding("zero-far", "warning", text, "wrench", count=len(trusted))]


def drift_findings(zeros: list[np.ndarray]) -> list[Finding]:
    """A remark on zeros (6,), N and N m, of one recording's trajectories that differ by more than noise."""
    findings: list[Finding] = []
    if len(zeros) > 1:
        stack = np.stack(zeros)[:, :3]
        drift = float(np.linalg.norm(stack.max(axis=0) - stack.min(axis=0)))
        if drift > DRIFT_WORTH_SAYING:
            text = f"wrench: its zero moves by {drift:.2f} N over {len(zeros)} trajectories; each has its own zero"
            findings.append(Finding("zero-drift", "info", text, "wrench", count=len(zeros)))
    return findings
