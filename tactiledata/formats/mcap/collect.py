"""Numbers of one signal as they come in, kept compactly until the whole recording has been read."""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from tactiledata.contract.records import Finding, Severity, Signal, Stamps
from tactiledata.contract.wording import agreeing, counted
from tactiledata.errors import BrokenLog
from tactiledata.formats.mcap.message_fields import NoSuchField


@dataclass
class FaultCount:
    """How often something was wrong in a stream, from when to when, and the first reason."""

    count: int = 0
    reason: str = ""
    start_ns: int | None = None
    end_ns: int | None = None

    def add(self, log_ns: int, reason: object) -> None:
        """Count one more."""
        if not self.count:
            self.reason, self.start_ns = " ".join(str(reason).split())[:200] or type(reason).__name__, log_ns
        self.count += 1
        self.end_ns = log_ns

    def finding(self, code: str, message: str, stream: str, severity: Severity = "damage") -> list[Finding]:
        """The finding, where there was anything; ``message`` may name its number, and the first reason.

        Parameters
        ----------
        code : str
            Code of the finding.
        message : str
            Text of the finding, with ``{messages}`` or ``{images}`` (their number and the noun), ``{are}`` (the verb
            that goes with it) and ``{reason}`` where they belong.
        stream : str
            The stream that it is about.
        severity : str
            How bad it is; damage by default.
        """
        if not self.count:
            return []
        text = message.format(
            messages=counted(self.count, "message"),
            images=counted(self.count, "image"),
            are=agreeing(self.count, "is", "are"),
            reason=self.reason,
        )
        return [Finding(code, severity, text, stream, start_ns=self.start_ns, end_ns=self.end_ns, count=self.count)]


@dataclass
class SignalBuffer:
    """One signal's samples.

    Parameters
    ----------
    name : str
    topic : str
    columns, units : (k,) names
    frame : str, optional
        The frame that is meant: messages with another frame_id are refused, messages without one are in it. ``None``:
        whatever comes, as long as it is always the same.
    misnamed : NoSuchField, optional
        The first path of the mapping that leads to no field of a message.
    """

    name: str
    topic: str
    columns: tuple[str, ...]
    units: tuple[str, ...] = ()
    frame: str | None = None
    log: array[int] = field(default_factory=lambda: array("q"))
    publish: array[int] = field(default_factory=lambda: array("q"))
    header: array[int] = field(default_factory=lambda: array("q"))
    values: array[float] = field(default_factory=lambda: array("d"))
    frames: Counter[str] = field(default_factory=Counter)
    faults: FaultCount = field(default_factory=FaultCount)
    refused: FaultCount = field(default_factory=FaultCount)
    absent: Counter[str] = field(default_factory=Counter)
    has_header: bool = False
    unframed: int = 0
    misnamed: NoSuchField | None = None

    def add(self, values: Sequence[float], log_ns: int, publish_ns: int, header_ns: int | None, frame: str) -> None:
        """One sample, unless it states another frame than the one that is wanted; one that states none has that.

        Parameters
        ----------
        values : (c,)
            One number for each column of the signal.
        log_ns, publish_ns : int
            Stamps of the recorder and of the publisher, ns.
        header_ns : int, optional
            Stamp in the message, ns; ``None`` where the message has no header.
        frame : str
            The frame that the message states; empty where it states none.
        """
        if self.frame is not None and frame != self.frame:
            if frame:
                self.refused.add(log_ns, repr(frame))
                return
            self.unframed += 1
            frame = self.frame
        self.frames[frame] += 1
        self.values.extend(values)
        self.log.append(log_ns)
        self.publish.append(publish_ns)
        if header_ns is not None:
            self.has_header = True
        self.header.append(header_ns or 0)

    def signal(self) -> Signal:
        """The samples as a signal.

        Raises
        ------
        BrokenLog
            They are expressed in different frames, and nothing says which one is meant.
        """
        if len(self.frames) > 1:
            listed = ", ".join(
                f"{frame!r} ({counted(count, 'message')})" for frame, count in sorted(self.frames.items())
            )
            raise BrokenLog(
                f"{self.topic} mixes frames: {listed}",
                f"one frame_id for the signal {self.name!r}",
                f"Say in a mapping which is meant: signals: {{{self.name}: {{topic: {self.topic}, frame: ...}}}}.",
                topic=self.topic,
                frames=sorted(self.frames),
            )
        values = np.array(self.values, dtype=np.float64).reshape(-1, len(self.columns))
        stamps = Stamps(
            np.array(self.log, dtype=np.int64),
            np.array(self.publish, dtype=np.int64),
            np.array(self.header, dtype=np.int64) if self.has_header else None,
        )
        return Signal(self.name, stamps, values, self.columns, next(iter(self.frames), ""), self.units)

    def findings(self) -> list[Finding]:
        """What was wrong with the samples."""
        found = self.faults.finding(
            "undecodable-message", f"{{messages}} of {self.topic} cannot be decoded: {{reason}}", self.name
        )
        found += self.refused.finding(
            "foreign-frame",
            f"{{messages}} of {self.topic} {{are}} left out: the frame is {{reason}}, {self.frame!r} is meant",
            self.name,
        )
        found += self._frame_findings()
        for what, count in sorted(self.absent.items()):
            text = f"{what} is missing in {counted(count, 'message')} of {self.topic}; it is NaN there"
            found.append(Finding("missing-joint", "warning", text, self.name, count=count))
        values = np.frombuffer(self.values, dtype=np.float64) if self.values else np.zeros(0)
        bad = ~np.isfinite(values).reshape(-1, len(self.columns)).all(axis=1)
        if bad.any():
            rows = np.flatnonzero(bad)
            text = f"NaN or infinity in {counted(len(rows), 'sample')} of {self.topic}; kept as recorded"
            found.append(
                Finding("non-finite", "warning", text, self.name, start_ns=self.log[int(rows[0])],
                        end_ns=self.log[int(rows[-1])], count=len(rows))
            )  # fmt: skip
        return found

    def _frame_findings(self) -> list[Finding]:
        """Findings that messages state no frame_id, with the frame that they are taken to be in."""
        if not self.unframed:
            return []
        text = (
            f"{counted(self.unframed, 'message')} of {self.topic} without a frame_id; the mapping says {self.frame!r}"
        )
        if self.refused.count or self.frames[self.frame or ""] > self.unframed:
            text += ", and other messages of the topic do state one"
            return [Finding("frame-in-part", "warning", text, self.name, count=self.unframed)]
        return [Finding("frame-stated", "info", text, self.name, count=self.unframed)]
