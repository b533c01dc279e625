"""A log format of one's own: text files of normal forces, first line ``# press-log 1``, then ``t_ns fz`` a line."""

from pathlib import Path

import numpy as np

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Finding, Recording, Signal, Source, Stamps
from tactiledata.errors import BrokenLog
from tactiledata.formats.base import Format, Inspection, TopicInfo

FIRST_LINE = "# press-log 1"


class PressLogFormat(Format):
    """Normal forces over time, nothing else."""

    name = "press_log"
    title = "normal forces as text"
    layout = "<any>.press    '# press-log 1', then a line 't_ns fz' (ns, N) per sample"

    def sniff(self, path):
        """Judged by the first line, not by the suffix."""
        if not path.is_file():
            return False
        with path.open("rb") as stream:
            return stream.read(len(FIRST_LINE)) == FIRST_LINE.encode()

    def sources(self, path):
        """One file is one recording."""
        return [Source(str(path), path.name, self.name, (str(path),))]

    def read(self, source, sink, mapping=None):
        """The forces; a line that is no pair of numbers is reported, and the rest is read."""
        rows, findings = [], []
        for number, line in enumerate(Path(source.path).read_text(encoding="utf-8").splitlines()[1:], start=2):
            try:
                t_ns, fz = line.split()
                rows.append((int(t_ns), float(fz)))
            except ValueError:
                text = f"line {number} is {line[:40]!r}, not 't_ns fz'; it was left out"
                findings.append(Finding("bad-row", "damage", text, "wrench"))
        if not rows:
            raise BrokenLog(f"{source.key} holds no sample", "lines 't_ns fz'", "Was the recorder started?")
        # times stay integers: nanoseconds since the epoch do not fit a float64
        stamps = Stamps(np.array([row[0] for row in rows], np.int64))
        values = np.zeros((len(rows), 6))
        values[:, 2] = [row[1] for row in rows]
        wrench = Signal("wrench", stamps, values, ("fx", "fy", "fz", "tx", "ty", "tz"))
        return Recording(source, LogDescription(), {"wrench": wrench}, findings=tuple(findings))

    def inspect(self, source, mapping=None, sink=None):
        """How many samples there are; with the recording, `tactiledata inspect` says what ingest would make of it."""
        recording = self.read(source, sink, mapping)
        samples = len(recording.signals["wrench"].values)
        streams = (TopicInfo("forces", "t_ns fz", "text", samples, role="wrench"),)
        return Inspection(source, streams, recording.findings, recording=recording)
