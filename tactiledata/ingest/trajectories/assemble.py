"""A recording as read becomes a take: on one clock, cut into trajectories, with contact forces at every frame."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.contract.description import LogDescription
from tactiledata.contract.provenance import provenance
from tactiledata.contract.records import Finding, FrameValues, Recording, Trajectory
from tactiledata.contract.take import UNUSABLE, StoredSignal, Take, findings_table
from tactiledata.ingest.checks.image_sizes import mark_strays
from tactiledata.ingest.checks.plausible import unused_units
from tactiledata.ingest.clocks.align import align
from tactiledata.ingest.clocks.clock_shifts import judge_frames, named_elsewhere
from tactiledata.ingest.clocks.rates import gap_findings
from tactiledata.ingest.clocks.timeline import put_on_host_clock
from tactiledata.ingest.forces.contact import ContactWrench, contact_wrench
from tactiledata.ingest.trajectories import frames as frame_tables
from tactiledata.ingest.trajectories.cut import (
    assign_frames,
    check_trajectories,
    lost_spans_hit,
    trajectory_table,
    within,
)
from tactiledata.ingest.trajectories.identity import name_sensors, sensor_facts
from tactiledata.ingest.trajectories.reference import find_references
from tactiledata.ingest.trajectories.segment import segment_by_contact, whole_recording

Decode = Callable[[NDArray[np.int64]], list[NDArray[np.uint8] | None]]
"""Images (H, W, 3) RGB of rows in the order of the sink; ``None`` where there is none or it does not decode."""


@dataclass(frozen=True)
class IngestOptions:
    """What a user may choose.

    Parameters
    ----------
    mapping : dict, optional
        Fits ``schemas/mapping.json``.
    format_name : str, optional
        Read as this format, whatever sniffing says.
    strict : bool
        Refuse a recording with any damage, instead of keeping what is whole.
    gap_limit_ns : int
        An aligned value that lies in a longer gap flags its frame.
    """

    mapping: Mapping[str, Any] | None = None
    format_name: str | None = None
    strict: bool = False
    gap_limit_ns: int = 100_000_000

    def document(self) -> dict[str, Any]:
        """The options that shape the output."""
        return {"mapping": self.mapping, "gap_limit_ns": self.gap_limit_ns}


@dataclass(frozen=True)
class Assembled:
    """A take, and the row in the sink of each of its frames."""

    take: Take
    order: NDArray[np.int64]


@dataclass
class _Findings:
    """Findings in the order in which they were met."""

    items: list[Finding] = field(default_factory=list)

    def add(self, *findings: Finding) -> None:
        self.items.extend(findings)


def assemble(recording: Recording, images: pa.Table, decode: Decode, sha256: str, options: IngestOptions) -> Assembled:
    """A take, ready to be checked and staged.

    Parameters
    ----------
    recording : Recording
    images : pa.Table
        The spool's columns, in the order of the sink.
    decode : callable
        For references and checks; called with few rows.
    sha256 : str
        Digest of the source's files.
    options : IngestOptions
    """
    said = _Findings([*recording.findings, *unused_units(recording)])
    captured = frame_tables.capture_times(recording, images)
    timed = put_on_host_clock(recording, frame_tables.times_by_camera(captured))
    said.add(*timed.findings, *captured.findings)
    signals = dict(timed.signals)
    displaced = _displaced_frames(recording, captured, signals, said)
    trajectories, segmented, contact = _cut(recording, signals, captured, said)
    sensors, trajectories = name_sensors(recording, captured, trajectories, sha256, said.add)
    if contact is not None:
        signals["contact_wrench"] = contact.signal

    # frames in the store's order, with what the other streams were at their moments
    owner = assign_frames(trajectories, captured.t_ns, sensors, images["trajectory"].to_pylist())
    owner[displaced & within(trajectories, owner, captured.t_ns)] = -1  # by a time that is not theirs
    order = frame_tables.frame_order(captured, owner)
    frame_t_ns = captured.t_ns[order]
    aligned = {name: align(signal, frame_t_ns, displaced[order]) for name, signal in sorted(signals.items())}
    force = _contact_force(aligned, len(order))
    flags = frame_tables.frame_flags(
        images["encoding"].take(pa.array(order)).to_pylist(),
        owner[order],
        {name: signal.gap_ns for name, signal in aligned.items()},
        options.gap_limit_ns,
    )
    ordered_sensors = [sensors[row] for row in order]
    frames = frame_tables.frames_table(captured, order, owner[order], ordered_sensors, force, flags)
    frames, sizes = mark_strays(frames, [trajectory.name for trajectory in trajectories])
    said.add(*sizes)
    spans = sorted({(trajectory.start_ns, trajectory.end_ns) for trajectory in trajectories})
    for name, signal in timed.signals.items():
        said.add(*gap_findings(name, signal.t_ns, spans))
    said.add(*lost_spans_hit(trajectories, said.items))
    is_usable = (frames["flags"].to_numpy() & UNUSABLE) == 0
    references = find_references(
        recording, ordered_sensors, order, np.where(is_usable, force, np.float32(np.nan)), decode, said.add
    )
    take = Take(
        source=recording.source,
        sha256=sha256,
        status=_status(said.items),
        description=dict(recording.description.without_units().document),
        provenance=provenance("ingest", {recording.source.key: sha256}, options.document()),
        frames=frames,
        trajectories=trajectory_table(trajectories, sha256, segmented, owner[order], force, signals),
        findings=findings_table(said.items),
        signals=signals,
        aligned=aligned,
        frame_values={name: _reordered(values, order) for name, values in recording.frame_values.items()},
        references=references,
        sensors=sensor_facts(recording.description, sorted(set(ordered_sensors) | {t.sensor for t in trajectories})),
    )
    return Assembled(take, order)


def _displaced_frames(
    recording: Recording,
    captured: frame_tables.CapturedFrames,
    signals: Mapping[str, StoredSignal],
    said: _Findings,
) -> NDArray[np.bool_]:
    """Return a mask (n,) of images, in the order of the sink, whose time is off."""
    crc = captured.images["crc32c"].to_numpy()
    times = {name: signal.t_ns for name, signal in signals.items()}
    jumped = judge_frames(recording, frame_tables.rows_by_camera(captured), captured.t_ns, crc, times)
    elsewhere = named_elsewhere(recording, captured.t_ns, captured.images["trajectory"].to_pylist())
    said.add(*jumped.findings, *elsewhere.findings)
    return jumped.is_off | elsewhere.is_off


def _cut(
    recording: Recording,
    signals: dict[str, StoredSignal],
    captured: frame_tables.CapturedFrames,
    said: _Findings,
) -> tuple[tuple[Trajectory, ...], str, ContactWrench | None]:
    """Trajectories, who named them, and the contact wrench."""
    checked = check_trajectories(recording.trajectories)
    known = {finding.code for finding in recording.findings}
    said.add(*(finding for finding in checked.findings if finding.code not in known))
    if checked.trajectories:
        contact = _contact(recording.description, signals, checked.trajectories)
        if contact is not None:
            said.add(*contact.findings)
        return checked.trajectories, "log", contact
    rough = _contact(recording.description, signals, ())
    if rough is None:
        whole, finding = _everything(signals, captured)
        said.add(*finding)
        return whole, "whole recording", None
    found, beginning = segment_by_contact(rough.signal, rough.noise, "")
    said.add(*filter(None, [beginning]))
    if not found:
        said.add(*rough.findings, Finding("no-contact", "warning", "no contact was found in the wrench", "wrench"))
        return (), "contact onset and release", rough
    # now that the contacts are known, each touch gets the zero of its own free air
    contact = _contact(recording.description, signals, found)
    assert contact is not None
    said.add(*contact.findings, *(finding for finding in rough.findings if finding.code == "tare-under-load"))
    return found, "contact onset and release", contact


def _contact(
    description: LogDescription, signals: dict[str, StoredSignal], trajectories: tuple[Trajectory, ...]
) -> ContactWrench | None:
    if "wrench" not in signals or not len(signals["wrench"].t_ns):
        return None
    spans = [(trajectory.name, trajectory.start_ns, trajectory.end_ns) for trajectory in trajectories]
    return contact_wrench(description, signals["wrench"], signals.get("tcp"), spans)


def _everything(
    signals: dict[str, StoredSignal], captured: frame_tables.CapturedFrames
) -> tuple[tuple[Trajectory, ...], list[Finding]]:
    times = [captured.t_ns, *(signal.t_ns for signal in signals.values())]
    times = [t_ns for t_ns in times if len(t_ns)]
    if not times:
        return (), []
    start, end = min(int(t_ns.min()) for t_ns in times), max(int(t_ns.max()) for t_ns in times)
    trajectories, finding = whole_recording(start, end, "")
    return trajectories, [finding]


def _contact_force(aligned: Mapping[str, Any], n_frames: int) -> NDArray[np.float32]:
    if "contact_wrench" not in aligned:
        return np.full(n_frames, np.nan, np.float32)
    return np.linalg.norm(aligned["contact_wrench"].values[:, :3], axis=1).astype(np.float32)


def _reordered(values: FrameValues, order: NDArray[np.int64]) -> FrameValues:
    return FrameValues(values.values[order], values.columns, values.units, values.note)


def _status(findings: list[Finding]) -> str:
    if any(finding.severity == "damage" for finding in findings):
        return "damaged"
    return "unverified" if any(finding.code == "crc-not-recorded" for finding in findings) else "ok"
