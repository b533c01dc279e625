"""Which frames and which samples belong to which trajectory."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from hashlib import sha256
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.contract.records import Finding, Times, Trajectory
from tactiledata.contract.take import TRAJECTORY_SCHEMA, StoredSignal
from tactiledata.ingest.trajectories.identity import part_name


@dataclass(frozen=True)
class Checked:
    """Trajectories in order of time, and what was wrong with them."""

    trajectories: tuple[Trajectory, ...]
    findings: tuple[Finding, ...]


def check_trajectories(trajectories: tuple[Trajectory, ...]) -> Checked:
    """Trajectories sorted by start; reversed ones left out, repeated names made different, overlaps said."""
    kept: list[Trajectory] = []
    findings: list[Finding] = []
    names: dict[str, int] = {}
    for trajectory in sorted(trajectories, key=lambda item: (item.start_ns, item.end_ns, item.name)):
        if trajectory.end_ns <= trajectory.start_ns:
            text = f"trajectory {trajectory.name!r} ends at or before its start; it holds nothing and was left out"
            findings.append(Finding("trajectory-reversed", "damage", text, trajectory=trajectory.name))
            continue
        names[trajectory.name] = names.get(trajectory.name, 0) + 1
        if names[trajectory.name] > 1:
            other = f"{trajectory.name}~{names[trajectory.name]}"
            text = f"two trajectories are called {trajectory.name!r}; the later one is kept as {other!r}"
            findings.append(Finding("trajectory-name-repeated", "warning", text, trajectory=other))
            trajectory = replace(trajectory, name=other)
        if kept and trajectory.start_ns < kept[-1].end_ns and _same_sensor(trajectory, kept[-1]):
            text = f"trajectories {kept[-1].name!r} and {trajectory.name!r} overlap; what both claim goes to the first"
            findings.append(
                Finding(
                    "trajectory-overlap",
                    "damage",
                    text,
                    trajectory=trajectory.name,
                    start_ns=trajectory.start_ns,
                    end_ns=min(kept[-1].end_ns, trajectory.end_ns),
                )
            )
        kept.append(trajectory)
    return Checked(tuple(kept), tuple(findings))


def _same_sensor(one: Trajectory, other: Trajectory) -> bool:
    return not one.sensor or not other.sensor or one.sensor == other.sensor


def assign_frames(
    trajectories: tuple[Trajectory, ...], t_ns: Times, sensors: list[str], named: list[str]
) -> NDArray[np.int32]:
    """Return the row of each frame's trajectory (n,), -1 outside any.

    A frame that names its trajectory belongs there. Any other belongs to the first trajectory whose half-open interval
    holds its time and whose sensor is its own, or not known.

    Parameters
    ----------
    trajectories : tuple of Trajectory
        Trajectories with their intervals.
    t_ns : (n,) int64 ns
        Host times of the frames.
    sensors : list of n str
        Serial of each frame's sensor; empty where it is not known.
    named : list of n str
        Trajectory that each frame names; empty where it names none.
    """
    rows = np.full(len(t_ns), -1, dtype=np.int32)
    by_name = {trajectory.name: row for row, trajectory in enumerate(trajectories)}
    frame_sensors = np.array(sensors, dtype=object)
    for row, trajectory in enumerate(trajectories):
        inside = (t_ns >= trajectory.start_ns) & (t_ns < trajectory.end_ns) & (rows < 0)
        if trajectory.sensor:
            inside &= (frame_sensors == trajectory.sensor) | (frame_sensors == "")
        rows[inside] = row
    for frame, name in enumerate(named):
        meant = by_name.get(name, by_name.get(part_name(name, sensors[frame])))
        if meant is not None:
            rows[frame] = meant
    return rows


def within(trajectories: tuple[Trajectory, ...], rows: NDArray[np.int32], t_ns: Times) -> NDArray[np.bool_]:
    """Return whether each frame (n,) lies in the interval of its trajectory; ``False`` where it has none.

    Parameters
    ----------
    trajectories : tuple of Trajectory
        Trajectories with their intervals.
    rows : (n,) int32
        Row of each frame's trajectory, -1 for none.
    t_ns : (n,) int64 ns
        Host times of the frames.
    """
    edges = np.array([(trajectory.start_ns, trajectory.end_ns) for trajectory in trajectories], np.int64).reshape(-1, 2)
    found = np.zeros(len(rows), dtype=bool)
    owned = rows >= 0
    found[owned] = (t_ns[owned] >= edges[rows[owned], 0]) & (t_ns[owned] < edges[rows[owned], 1])
    return found


def trajectory_table(
    trajectories: tuple[Trajectory, ...],
    source_digest: str,
    segmented: str,
    frame_trajectory: NDArray[np.int32],
    contact_force: NDArray[np.float32],
    signals: dict[str, StoredSignal],
) -> pa.Table:
    """Return the table of trajectories, with ``TRAJECTORY_SCHEMA``.

    Parameters
    ----------
    trajectories : tuple of Trajectory
        The rows of the table.
    source_digest : str
        SHA-256 of the recording's files, of which the trajectories' uids are made.
    segmented : "log", "contact onset and release" or "whole recording"
        Who cut the recording into trajectories.
    frame_trajectory : (n,) int32
        Row of each frame's trajectory, ascending; those outside any, -1, at the end.
    contact_force : (n,) float32, N
        Contact force of each frame, NaN where it is not known.
    signals : dict, name -> StoredSignal
        Signals of the recording; the table holds which of their rows lie in each trajectory.
    """
    columns: dict[str, list[Any]] = {field.name: [] for field in TRAJECTORY_SCHEMA}
    inside = frame_trajectory[: int((frame_trajectory >= 0).sum())]
    for row, trajectory in enumerate(trajectories):
        start, stop = (int(edge) for edge in np.searchsorted(inside, [row, row + 1]))
        ranges = {
            name: [int(edge) for edge in np.searchsorted(signal.t_ns, [trajectory.start_ns, trajectory.end_ns])]
            for name, signal in sorted(signals.items())
        }
        values = {
            "uid": trajectory_uid(source_digest, trajectory.name),
            "trajectory": trajectory.name,
            "source": 0,
            "sensor": trajectory.sensor,
            "indenter": trajectory.indenter,
            "start_ns": trajectory.start_ns,
            "end_ns": trajectory.end_ns,
            "frame_start": start,
            "frame_stop": stop,
            "signal_rows": json.dumps(ranges),
            "peak_force": _peak(signals, ranges, contact_force[start:stop]),
            "segmented": segmented,
            "parent": "",
            "extra": json.dumps(dict(trajectory.extra), sort_keys=True, default=str),
        }
        for name, value in values.items():
            columns[name].append(value)
    return pa.table(columns, schema=TRAJECTORY_SCHEMA)


def trajectory_uid(source_digest: str, name: str) -> str:
    """16 hex digits that tell this trajectory from any other, the same wherever its source is ingested."""
    return sha256(f"{source_digest}/{name}".encode()).hexdigest()[:16]


def _peak(signals: dict[str, StoredSignal], ranges: dict[str, list[int]], force: NDArray[np.float32]) -> float:
    """Largest contact force, N, over the native samples, or over the frames where there is no such signal."""
    if "contact_wrench" in signals:
        start, stop = ranges["contact_wrench"]
        native = np.linalg.norm(signals["contact_wrench"].values[start:stop, :3], axis=1)
        force = native.astype(np.float32)
    finite = force[np.isfinite(force)]
    return float(finite.max()) if len(finite) else float("nan")


def lost_spans_hit(trajectories: tuple[Trajectory, ...], findings: list[Finding]) -> list[Finding]:
    """One finding per trajectory that a lost span of the recording overlaps."""
    spans = [
        (finding.start_ns, finding.end_ns)
        for finding in findings
        if finding.severity == "damage"
        and finding.start_ns is not None
        and finding.end_ns is not None
        and not finding.trajectory  # about the trajectory itself, not about samples that were lost
    ]
    return [
        Finding(
            "trajectory-incomplete",
            "damage",
            f"trajectory {trajectory.name!r} lost data to damage of the recording",
            trajectory=trajectory.name,
            start_ns=trajectory.start_ns,
            end_ns=trajectory.end_ns,
        )
        for trajectory in trajectories
        if any(start < trajectory.end_ns and end >= trajectory.start_ns for start, end in spans)
    ]
