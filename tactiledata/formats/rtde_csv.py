"""CSV files that UR's own recorders write over RTDE, without ROS: robot and wrist force, no images, no host clock."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Recording, Signal, Source, Stamps, Times, Values
from tactiledata.errors import BrokenLog, UsageError
from tactiledata.formats.reading.corpus import CorpusFormat
from tactiledata.formats.reading.csv_cells import CsvTable, Mask, listed
from tactiledata.formats.reading.csv_tables import read_csv_table
from tactiledata.formats.reading.described import described_trajectories
from tactiledata.formats.reading.intake import Intake
from tactiledata.formats.reading.rotation_vectors import poses_from_rotation_vectors
from tactiledata.units import SIGNAL_COLUMNS

CLOCK = "timestamp"
SEPARATORS = ", "
"""ur_rtde writes commas, UR's own example client blanks."""

GROUPS = {"joints": "actual_q", "tcp": "actual_TCP_pose", "ur_wrench": "actual_TCP_force"}
"""Signal -> the vector of six that it is read from."""

UR_WRENCH_FRAME = "tcp_with_base_axes"
"""UR gives the wrench about the tool centre point, in axes parallel to the base."""

RESTART = 1_000_000_000
"""ns. A step back of the controller's clock beyond this is a restart, not a late line."""

_VECTOR = re.compile(rb"(actual|target)_\w+_[0-5]")

SNIFFED = 64 * 2**10
"""Bytes in which the header is looked for."""


class RtdeCsvFormat(CorpusFormat):
    """A CSV of UR's real-time data exchange.

    ``actual_TCP_force`` is the arm's own estimate at its wrist. It becomes the signal ``ur_wrench``, never ``wrench``:
    that name is kept for the force sensor under the tactile sensor. Times are seconds since the controller started.
    """

    name = "rtde_csv"
    title = "UR RTDE recording"
    layout = """
<any>.csv               parted by commas or blanks, columns in any order:
                        timestamp                          s, controller clock
                        actual_q_0 .. actual_q_5           rad
                        actual_TCP_pose_0 .. _5            m, and a rotation vector in rad
                        actual_TCP_force_0 .. _5           N, N m
"""

    def sniff(self, path: Path) -> bool:
        """Whether a text file's first line names RTDE's columns."""
        if path.suffix.lower() not in (".csv", ".txt") or not path.is_file():
            return False
        try:
            with path.open("rb") as stream:
                header = stream.readline(SNIFFED)
        except OSError:
            return False
        # semicolons too: such a file is refused with a reason, rather than not recognised
        names = re.split(rb'[\s,;"]+', header.removeprefix(b"\xef\xbb\xbf"))
        return CLOCK.encode() in names and any(_VECTOR.fullmatch(name) for name in names)

    def sources(self, path: Path) -> Sequence[Source]:
        """The file is one recording."""
        self.require(path)
        return [self.make_source(path, path, [path])]

    def record(self, source: Source, intake: Intake, mapping: Mapping[str, Any] | None) -> Recording:
        """The signals of the file.

        Parameters
        ----------
        source : Source
            One CSV file, as `sources` found it.
        intake : Intake
            Takes findings; the file has no images; it is read afterwards for values and findings.
        mapping : dict, optional
            A mapping document; its ``signals`` may name further columns.

        Raises
        ------
        BrokenLog
            The file has no clock, or no whole vector that reads.
        """
        table = read_csv_table(Path(source.path), separators=SEPARATORS)
        table.require((CLOCK,), "Record the column timestamp with the others: without it no sample has a time.")
        t_ns, has_time = table.seconds(CLOCK)
        findings = [*table.findings]
        findings += table.row_finding("csv-time", ~has_time, f"have a {CLOCK} that is no number; left out")
        columns = {name: tuple(f"{prefix}_{axis}" for axis in range(6)) for name, prefix in GROUPS.items()}
        signals: dict[str, Signal] = {}
        for name in GROUPS:
            there = [column for column in columns[name] if column in table.columns]
            if there and len(there) < 6:
                message = f"{table.name}: of {GROUPS[name]}_0 to _5 only {listed(there)} are there; {name} is not read"
                intake.note("columns-incomplete", "damage", message, name)
            if len(there) < 6:
                continue
            values, is_finite = table.numbers(columns[name])
            what = f"have a value in {GROUPS[name]} that is no finite number; left out"
            findings += table.row_finding("csv-value", has_time & ~is_finite, what, name)
            if (has_time & is_finite).any():
                signals[name] = _signal(name, t_ns, values, has_time & is_finite)
        used = {CLOCK, *(column for group in columns.values() for column in group)}
        used |= _add_mapped(signals, table, t_ns, has_time, mapping or {})
        if not signals:
            raise BrokenLog(
                f"{table.name} has the columns {listed(table.columns)} and no whole vector that reads",
                f"at least one of {listed(f'{prefix}_0 to _5' for prefix in GROUPS.values())}",
                "Record them, or name the columns you need under 'signals' in a mapping.",
            )
        _note_clock(intake, table, t_ns[has_time])
        others = [column for column in table.columns if column not in used]
        if others:
            message = f"{table.name}: the columns {listed(others[:8])}{' …' * (len(others) > 8)} were not read"
            intake.note("columns-ignored", "info", message, count=len(others))
        description = _description(source, mapping or {})
        trajectories = tuple(described_trajectories(description))
        return Recording(source, description, signals, trajectories, (*findings, *intake.findings), "log")


def _signal(name: str, t_ns: Times, values: Values, rows: Mask) -> Signal:
    stamps = Stamps(t_ns[rows])
    if name == "tcp":
        return Signal(name, stamps, poses_from_rotation_vectors(values[rows]), SIGNAL_COLUMNS["tcp"], "base")
    if name == "joints":
        return Signal(name, stamps, values[rows], SIGNAL_COLUMNS["joints"])
    return Signal(name, stamps, values[rows], SIGNAL_COLUMNS["wrench"], UR_WRENCH_FRAME)


def _add_mapped(
    signals: dict[str, Signal], table: CsvTable, t_ns: Times, has_time: Mask, mapping: Mapping[str, Any]
) -> set[str]:
    """Signals that a mapping reads from columns of its choice; returns those columns."""
    used: set[str] = set()
    for name, facts in mapping.get("signals", {}).items():
        columns = tuple(facts.get("fields", ()))
        if not columns:
            continue
        if name in SIGNAL_COLUMNS:
            raise UsageError(
                f"the mapping reads the signal {name!r} from RTDE columns {listed(columns)}",
                "another name: wrench is the force sensor's, and joints and tcp are read without a mapping",
                "Call it, for example, ur_wrench_raw.",
            )
        table.require(columns, f"The mapping names them as fields of the signal {name!r}.")
        values, is_finite = table.numbers(columns)
        rows = has_time & is_finite
        units = tuple(facts.get("units", ("?",) * len(columns)))
        used.update(columns)
        if rows.any():
            stamps = Stamps(t_ns[rows])
            signals[name] = Signal(name, stamps, values[rows], columns, str(facts.get("frame", "")), units)
    return used


def _note_clock(intake: Intake, table: CsvTable, t_ns: Times) -> None:
    intake.note(
        "controller-clock",
        "warning",
        f"{table.name}: times are the robot controller's, from {t_ns.min() / 1e9:.3f} s to {t_ns.max() / 1e9:.3f} s, "
        "not UTC; state clocks in a description before comparing them with other recordings",
    )
    steps = np.diff(t_ns)
    restarts = np.flatnonzero(steps < -RESTART)
    if len(restarts):
        message = (
            f"{table.name}: the controller clock jumps back by {-steps[restarts[0]] / 1e9:.3f} s at row "
            f"{restarts[0] + 2}: it was restarted, and sorting by time would mix what was before and after"
        )
        intake.note("controller-restart", "damage", message, count=len(restarts))


def _description(source: Source, mapping: Mapping[str, Any]) -> LogDescription:
    addition = mapping.get("description")
    empty = LogDescription({}, source.key)
    return empty.merged(addition, f"mapping for {source.key}") if addition else empty
