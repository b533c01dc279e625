"""trajectories.csv (or the list in log.yaml): which intervals of the host clock are which touch."""

from __future__ import annotations

import bisect
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Finding, Trajectory
from tactiledata.contract.wording import agreeing, counted
from tactiledata.formats.folder.files import LogFolder
from tactiledata.formats.folder.signals import open_table
from tactiledata.formats.reading.csv_cells import CsvTable, free_values, listed, shortened
from tactiledata.formats.reading.described import KNOWN, described_trajectories

TABLE = "trajectories.csv"
REQUIRED = ("trajectory", "start_ns", "end_ns")


@dataclass(frozen=True)
class TouchTable:
    """The trajectories of a log, looked up by name or by time.

    Parameters
    ----------
    trajectories : tuple of Trajectory
        In the order of the table, names made unique.
    recorded : dict
        Name in the table -> the trajectories that it names; one, in a sound log.
    findings : tuple of Finding
    """

    trajectories: tuple[Trajectory, ...]
    recorded: dict[str, list[Trajectory]]
    findings: tuple[Finding, ...]
    _by_start: list[Trajectory] = field(default_factory=list)
    _starts: list[int] = field(default_factory=list)
    _reaches: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._by_start.extend(sorted(self.trajectories, key=lambda touch: touch.start_ns))
        self._starts.extend(touch.start_ns for touch in self._by_start)
        self._reaches.extend(itertools.accumulate((touch.end_ns for touch in self._by_start), max))

    def at(self, t_ns: int) -> Trajectory | None:
        """The trajectory whose interval holds a time; the latest to start where several do."""
        place = bisect.bisect_right(self._starts, t_ns) - 1
        while place >= 0 and t_ns < self._reaches[place]:
            if t_ns < self._by_start[place].end_ns:
                return self._by_start[place]
            place -= 1
        return None

    def named(self, name: str, t_ns: int) -> Trajectory | None:
        """The trajectory that the table calls by this name; of several, the one that holds the time."""
        known = self.recorded.get(name, [])
        return next((touch for touch in known if touch.start_ns <= t_ns < touch.end_ns), known[0] if known else None)


def read_trajectories(folder: LogFolder, description: LogDescription) -> TouchTable:
    """The trajectories that a log names.

    Raises
    ------
    BrokenLog
        The table lacks a column or is no table of ours.
    """
    table, said = open_table(folder, TABLE, "")
    findings = list(said)
    rows: list[Trajectory] = []
    if table is not None:
        rows, faults = _rows(table)
        findings.extend(faults)
    elif description.document.get("trajectories"):
        rows = described_trajectories(description)
    elif not said:
        message = f"there is no {TABLE}: contacts will be looked for in the wrench"
        findings.append(Finding("no-trajectories", "info", message))
    rows, faults = _with_sensor(rows, description)
    findings.extend(faults)
    findings.extend(_unknown_names(rows, description))
    trajectories, recorded, faults = _unique(rows)
    return TouchTable(tuple(trajectories), recorded, (*findings, *faults, *_overlaps(trajectories)))


def _rows(table: CsvTable) -> tuple[list[Trajectory], list[Finding]]:
    """The trajectories of all rows that read, free columns kept."""
    table.require(REQUIRED, f"docs/formats-folder.md shows a {TABLE} that works.")
    names = table.text("trajectory")
    starts, has_start = table.nanoseconds("start_ns")
    ends, has_end = table.nanoseconds("end_ns")
    has_name = np.array([bool(name) for name in names], bool)
    findings = table.row_finding("trajectory-time", ~(has_start & has_end), "have no integer start or end; left out")
    findings += table.row_finding("trajectory-name", ~has_name, "name no trajectory; left out")
    is_reversed = has_start & has_end & (ends <= starts)
    findings += table.row_finding("trajectory-reversed", is_reversed, "end before they start; left out")
    sensors, indenters = (
        table.text(column) if column in table.columns else [""] * len(table) for column in ("sensor", "indenter")
    )
    free = {column: free_values(table.text(column)) for column in table.columns if column not in KNOWN}
    rows = [
        Trajectory(
            names[row],
            int(starts[row]),
            int(ends[row]),
            sensors[row],
            indenters[row],
            {column: values[row] for column, values in free.items()},
        )
        for row in np.flatnonzero(has_start & has_end & has_name & ~is_reversed)
    ]
    return rows, findings


def _with_sensor(rows: Sequence[Trajectory], description: LogDescription) -> tuple[list[Trajectory], list[Finding]]:
    """Rows without a sensor get the only one there is; of several, none can be guessed."""
    empty = [touch.name for touch in rows if not touch.sensor]
    if not empty:
        return list(rows), []
    sensors, name = list(description.sensors), agreeing(len(empty), "names", "name")
    if len(sensors) == 1:
        message = f"{counted(len(empty), 'trajectory')} {name} no sensor: {sensors[0]!r} is the only one"
        finding = Finding("trajectory-sensor-taken", "info", message, count=len(empty))
        return [touch if touch.sensor else replace(touch, sensor=sensors[0]) for touch in rows], [finding]
    message = f"{counted(len(empty), 'trajectory')} {name} none of the {len(sensors)} sensors: {listed(empty[:3])}"
    return list(rows), [Finding("trajectory-sensor-missing", "damage", message, count=len(empty))]


def _unknown_names(rows: Sequence[Trajectory], description: LogDescription) -> list[Finding]:
    """A name with a spelling mistake would become another sensor or indenter, and leak across a split."""
    findings = []
    for kind, known in (("sensor", description.sensors), ("indenter", description.indenters)):
        used = [getattr(touch, kind) for touch in rows]
        unknown = sorted({name for name in used if name and name not in known})
        if unknown:
            message = (
                f"{TABLE} names the {kind} {listed(unknown[:5])}, which log.yaml does not have; it has {listed(known)}"
            )
            count = sum(name in unknown for name in used)
            findings.append(Finding(f"{kind}-not-described", "damage", message, count=count))
    return findings


def _unique(
    rows: Sequence[Trajectory],
) -> tuple[list[Trajectory], dict[str, list[Trajectory]], list[Finding]]:
    """Trajectories with unique names, by their recorded name, and findings; a later one becomes ``name~2``."""
    taken = {touch.name for touch in rows}
    recorded: dict[str, list[Trajectory]] = {}
    trajectories = []
    for touch in rows:
        known = recorded.setdefault(touch.name, [])
        name, number = touch.name, len(known) + 1
        while known and name in taken:
            name, number = f"{touch.name}~{number}", number + 1
        taken.add(name)
        known.append(replace(touch, name=name))
        trajectories.append(known[-1])
    repeated = [name for name, known in recorded.items() if len(known) > 1]
    if not repeated:
        return trajectories, recorded, []
    message = f"{TABLE}: {listed(repeated[:5])} name several trajectories; the later ones are called name~2 and so on"
    return trajectories, recorded, [Finding("trajectory-name-repeated", "warning", message, count=len(repeated))]


def _overlaps(trajectories: Sequence[Trajectory]) -> list[Finding]:
    """One finding about all trajectories that start before one of the same sensor has ended."""
    overlaps: list[Finding] = []
    latest: Trajectory | None = None
    for touch in sorted(trajectories, key=lambda touch: (touch.sensor, touch.start_ns, touch.end_ns)):
        if latest is not None and touch.sensor != latest.sensor:
            latest = None
        if latest is not None and touch.start_ns < latest.end_ns:
            end = min(touch.end_ns, latest.end_ns)
            message = (
                f"{shortened(touch.name, 60)!r} overlaps {shortened(latest.name, 60)!r} by "
                f"{(end - touch.start_ns) / 1e9:.3f} s: samples there would be in both"
            )
            overlaps.append(Finding("trajectory-overlap", "damage", message, "", touch.name, touch.start_ns, end))
        if latest is None or touch.end_ns > latest.end_ns:
            latest = touch
    if len(overlaps) < 2:
        return overlaps
    message = f"{TABLE}: {len(overlaps)} trajectories overlap an earlier one; first, {overlaps[0].message}"
    return [Finding("trajectory-overlap", "damage", message, count=len(overlaps))]
