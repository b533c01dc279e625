"""A recording's streams on the host clock, sorted, with what was done to them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.contract.records import Finding, Recording, Signal, Stamps, Times
from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.clocks import choose_clock, time_order
from tactiledata.ingest.rates import measure_rate, rate_findings


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
    choice = choose_clock(signal.name, signal.stamps, recording.host_clock, offset)
    order, said = time_order(signal.name, choice.t_ns)
    rows: Times = np.arange(len(choice.t_ns)) if order is None else order
    t_ns, values = choice.t_ns[rows], signal.values[rows]
    rate = measure_rate(t_ns, values)
    attributes = {"clock": choice.clock, "shift_ns": choice.shift_ns, **rate.document()}
    stored = StoredSignal(
        t_ns, values, signal.columns, signal.units, signal.frame, signal.stamps.take(rows), attributes
    )
    return stored, [*choice.findings, *said, *rate_findings(signal.name, signal.columns, rate)]


def image_times(recording: Recording, camera: str, stamps: Stamps) -> tuple[Times, dict[str, object], list[Finding]]:
    """Host times of one camera's images in the order of the recording, the clock used, and findings."""
    offset = recording.description.clock_offset("frames")
    choice = choose_clock(camera, stamps, recording.host_clock, offset)
    _, said = time_order(camera, choice.t_ns)
    return choice.t_ns, {"clock": choice.clock, "shift_ns": choice.shift_ns}, [*choice.findings, *said]
