"""Which of three time stamps a stream lives by, and putting the stream on the host clock.

Every message carries up to three stamps: when the recorder wrote it (log), when the sender sent it (publish), and what
it says itself (header). The header is closest to the measurement, but may be unset, jump, or run on another clock.
All three are kept in the store; this module says which one was taken, and why.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.contract.records import Finding, Stamps, Times
from tactiledata.errors import BrokenLog
from tactiledata.ingest.clocks.witnesses import usual_distance

NEAR = 1_000_000_000
"""ns. A header clock whose median distance to the log time is below this is taken to be the host clock itself."""

STEADY = 200_000_000
"""ns. Spread (5th to 95th percentile) of log minus header above which a header clock is not steady."""


AROUND = 10
"""Messages on either side of a jump of a header clock that its size is taken from."""


@dataclass(frozen=True)
class ClockChoice:
    """Times on the host clock and how they came about.

    Parameters
    ----------
    t_ns : (n,) int64
        In the order of the samples as recorded; may be out of order.
    clock : str
        ``"header"``, ``"header+shift"``, ``"publish"`` or ``"log"``.
    shift_ns : int
        What was added to the stamps of that clock.
    findings : tuple of Finding
    """

    t_ns: Times
    clock: str
    shift_ns: int
    findings: tuple[Finding, ...]


def choose_clock(
    stream: str, stamps: Stamps, preference: str = "auto", stated_offset_ns: int | None = None
) -> ClockChoice:
    """Times of a stream on the host clock.

    Parameters
    ----------
    stream : str
        For messages.
    stamps : Stamps
    preference : "auto", "header", "publish" or "log"
        ``auto``: the header where it is set, in order and steady against the log time, else the log time. A header
        clock that is steady but far from the log time is another machine's: it is shifted by the median distance.
    stated_offset_ns : int, optional
        Offset that the recording states (host = stream + offset), 0 too. It wins over an estimate. The log time
        beside other stamps is the host's already, and gets none.

    Raises
    ------
    BrokenLog
        A stated offset takes times beyond what 64 bits hold.
    """
    if len(stamps) == 0:
        return ClockChoice(stamps.log, "log", 0, ())
    is_only_clock = stamps.header is None and stamps.publish is None
    offset_ns = stated_offset_ns or 0
    log_offset_ns = offset_ns if is_only_clock else 0
    if preference == "log":
        return ClockChoice(_moved(stream, stamps.log, log_offset_ns), "log", log_offset_ns, ())
    if preference == "publish" and stamps.publish is not None:
        return ClockChoice(_moved(stream, stamps.publish, offset_ns), "publish", offset_ns, ())
    if preference == "publish":
        return ClockChoice(_moved(stream, stamps.log, log_offset_ns), "publish", log_offset_ns, ())
    header = stamps.header
    reason = _why_not_header(stamps)
    if preference == "header" and header is not None and bool((header > 0).all()):
        return ClockChoice(_moved(stream, header, offset_ns), "header", offset_ns, ())
    if header is None or reason:
        findings = _log_time_taken(stream, reason, offset_ns - log_offset_ns)
        return ClockChoice(_moved(stream, stamps.log, log_offset_ns), "log", log_offset_ns, findings)
    if stated_offset_ns is not None:
        return ClockChoice(_moved(stream, header, offset_ns), "header", offset_ns, ())
    # the middle one, not np.median: its float64 would round epoch nanoseconds
    distance = int(np.partition(stamps.log - header, len(header) // 2)[len(header) // 2])
    if abs(distance) < NEAR:
        return ClockChoice(header, "header", 0, ())
    shifted = Finding(
        "clock-shifted",
        "info",
        f"{stream}: its header clock is {distance / 1e9:.3f} s from the host's; shifted by the median distance, "
        "which holds the transport delay too",
        stream,
        count=len(stamps),
    )
    return ClockChoice(header + distance, "header+shift", distance, (shifted,))


def _moved(stream: str, t_ns: Times, offset_ns: int) -> Times:
    """Times with a stated offset; where 64 bits do not hold them, an error instead of times of another millennium."""
    limits = np.iinfo(np.int64)
    if int(t_ns.min()) + offset_ns < limits.min or int(t_ns.max()) + offset_ns > limits.max:
        raise BrokenLog(
            f"{stream}: its stated offset of {offset_ns} ns takes its times beyond what 64 bits hold",
            "host = stream + offset, in nanoseconds",
            "Mend offset_ns of that stream under clocks.",
            stream=stream,
        )
    return t_ns + offset_ns


def _log_time_taken(stream: str, reason: str, unused_offset_ns: int) -> tuple[Finding, ...]:
    """What is to be said where the log time is taken: why, and that a stated offset was not added to it."""
    if unused_offset_ns:
        reason = (
            f"{reason or 'there are no header stamps'}; the stated offset of {unused_offset_ns / 1e9:+.3f} s is of "
        )
        reason += "the stream's own clock, and was not added"
    return (Finding("clock-log-time", "info", f"{stream}: log time taken, {reason}", stream),) if reason else ()


def _why_not_header(stamps: Stamps) -> str:
    """Why the header stamps cannot be taken; empty where they can, or where there are none by design."""
    header = stamps.header
    if header is None:
        return ""
    unset = int((header <= 0).sum())
    if unset:
        return f"{unset} of {len(header)} header stamps are not set"
    backwards = int((np.diff(header) < 0).sum())
    if backwards:
        return f"header stamps run backwards at {backwards} of {len(header)} samples"
    if len(np.unique(header)) < 0.5 * len(header):
        return "more than half of the header stamps repeat the one before"
    lag = stamps.log - header
    low, high = np.percentile(lag - lag[0], [5, 95])
    if high - low > STEADY:
        return f"the header clock wanders {(high - low) / 1e6:.0f} ms against the log time"
    if jump := _jump(stamps.log, header):
        return f"the header clock jumps by {jump / 1e9:+.3f} s against the log time"
    return ""


def _jump(log: Times, header: Times) -> int:
    """Return by how much (ns) a header clock runs ahead of the log time at once, and stays there; 0 where it does not.

    A recorder that stalls writes late and catches up: there the log time is ahead, and the header falls back to it.
    """
    lag = log - header
    for row in np.flatnonzero(np.diff(lag) < -(STEADY + 2 * usual_distance(header))) + 1:
        before, after = int(np.median(lag[max(row - AROUND, 0) : row])), int(np.median(lag[row : row + AROUND]))
        if before - after > STEADY:
            return before - after
    return 0


def time_order(stream: str, t_ns: Times) -> tuple[Times | None, tuple[Finding, ...]]:
    """Row order that sorts the times (``None``: already sorted), and what is to be said about it."""
    steps = np.diff(t_ns)
    findings: list[Finding] = []
    # in order, so that rows which stand twice are met beside each other
    repeated = int((np.diff(np.sort(t_ns)) == 0).sum())
    if repeated:
        findings.append(
            Finding(
                "duplicate-stamps",
                "warning",
                f"{stream}: {repeated} of {len(t_ns)} samples have the time of the sample before; all are kept",
                stream,
                count=repeated,
            )
        )
    backwards = int((steps < 0).sum())
    if not backwards:
        return None, tuple(findings)
    findings.append(
        Finding(
            "time-order",
            "warning",
            f"{stream}: {backwards} of {len(t_ns)} samples are earlier than the one before, by up to "
            f"{-int(steps.min()) / 1e6:.1f} ms; sorted",
            stream,
            count=backwards,
        )
    )
    return np.argsort(t_ns, kind="stable"), tuple(findings)
