"""A recording's streams on the host clock, sorted, with what was done to them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactiledata.contract.records import Finding, Recording, Signal, Stamps, Times, Values
from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.align import POSE_COLUMNS, broken_rotations
from tactiledata.ingest.clocks import choose_clock, time_order
from tactiledata.ingest.rates import measure_rate, rate_findings

LATEST = 2.0**62
"""ns since the epoch, in either direction: the year 2116. Differences of such times still fit an int64."""


@dataclass(frozen=True)
class Timed:
    """Signals by name on the host clock, and findings."""

    signals: dict[str, StoredSignal]
    findings: tuple[Finding, ...]


def put_on_host_clock(recording: Recording) -> Timed:
    """All signals of a recording, sorted by host time; values unchanged."""
    stored: dict[str, StoredSignal] = {}
    findings: list[Finding] = []
    for name, signal in recording.signals.items():
        stored[name], said = _stored(signal, recording)
        findings.extend(said)
    return Timed(stored, tuple(findings))


def _stored(signal: Signal, recording: Recording) -> tuple[StoredSignal, list[Finding]]:
    offset = recording.description.clock_offset(signal.name)
    signal, impossible = _possible(signal)
    choice = choose_clock(signal.name, signal.stamps, recording.host_clock, offset)
    order, said = time_order(signal.name, choice.t_ns)
    rows: Times = np.arange(len(choice.t_ns)) if order is None else order
    t_ns, values = choice.t_ns[rows], signal.values[rows]
    said = (*said, *_rotation_findings(signal, values))
    rate = measure_rate(t_ns, values)
    attributes = {"clock": choice.clock, "shift_ns": choice.shift_ns, **rate.document()}
    stored = StoredSignal(
        t_ns, values, signal.columns, signal.units, signal.frame, signal.stamps.take(rows), attributes
    )
    return stored, [*impossible, *choice.findings, *said, *rate_findings(signal.name, signal.columns, rate)]


def _possible(signal: Signal) -> tuple[Signal, list[Finding]]:
    """The samples whose time a clock can show; the others cannot be placed, nor their distances computed in int64."""
    beyond = np.abs(signal.stamps.log.astype(np.float64)) > LATEST
    if not beyond.any():
        return signal, []
    text = f"{signal.name}: {int(beyond.sum())} of {len(beyond)} samples have a time beyond the year 2116; left out"
    kept = replace(signal, stamps=signal.stamps.take(~beyond), values=signal.values[~beyond])
    return kept, [Finding("time-impossible", "damage", text, signal.name, count=int(beyond.sum()))]


def _rotation_findings(signal: Signal, values: Values) -> list[Finding]:
    if signal.columns != POSE_COLUMNS:
        return []
    broken = int((broken_rotations(values) & np.isfinite(values).all(axis=1)).sum())
    if not broken:
        return []
    text = f"{signal.name}: {broken} of {len(values)} poses have a quaternion that is no rotation; they are left out"
    return [Finding("rotation-broken", "damage", text, signal.name, count=broken)]


def image_times(recording: Recording, camera: str, stamps: Stamps) -> tuple[Times, dict[str, object], list[Finding]]:
    """Host times of one camera's images in the order of the recording, the clock used, and findings."""
    offset = recording.description.clock_offset("frames")
    choice = choose_clock(camera, stamps, recording.host_clock, offset)
    _, said = time_order(camera, choice.t_ns)
    return choice.t_ns, {"clock": choice.clock, "shift_ns": choice.shift_ns}, [*choice.findings, *said]
