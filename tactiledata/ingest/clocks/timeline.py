"""A recording's streams on the host clock, sorted, with what was done to them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.records import Finding, Recording, Signal, Stamps, Times, Values
from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.clocks.align import POSE_COLUMNS, broken_rotations
from tactiledata.ingest.clocks.clock_shifts import shift_finding, shift_of, span_of, touched_span
from tactiledata.ingest.clocks.clock_steps import LEFT_OUT, judge_steps
from tactiledata.ingest.clocks.clocks import ClockChoice, choose_clock, time_order
from tactiledata.ingest.clocks.rates import measure_rate, rate_findings
from tactiledata.ingest.clocks.witnesses import IMAGES, SIGNAL, STAMPS, TRAJECTORIES, Witness, witness_of

LATEST = 2.0**62
"""ns since the epoch, in either direction: the year 2116. Differences of times before it still fit an int64."""

LARGEST = 1e8
"""Largest reading that is kept of forces (N), torques (N m), lengths (m), angles (rad) and temperatures (K).

No sensor measures so much. Forces up to 100 N that are written in micronewtons stay: a wrong unit is said of them, and
nothing is lost."""

MEASURED_UNITS = frozenset({"N", "N m", "m", "rad", "K"})
"""Units whose numbers are held against ``LARGEST``."""

LEAST_JITTER = 1_000
"""ns. Transport takes a time that varies by more; below it, two stamps are of one clock."""


@dataclass(frozen=True)
class Timed:
    """Signals by name on the host clock, and findings."""

    signals: dict[str, StoredSignal]
    findings: tuple[Finding, ...]


def put_on_host_clock(recording: Recording, cameras: Mapping[str, Times] = MappingProxyType({})) -> Timed:
    """All signals of a recording, sorted by host time and unchanged, without samples that cannot be.

    Left out are those whose clock had jumped, and those with a time or a number that cannot be.

    Parameters
    ----------
    recording : Recording
    cameras : mapping of (n,) int64, optional
        Host times of each camera's images, which tell a pause of a signal from a jump of its clock.
    """
    findings: dict[str, list[Finding]] = {}
    signals: dict[str, Signal] = {}
    choices: dict[str, ClockChoice] = {}
    for name, signal in recording.signals.items():
        placed, findings[name] = _possible(signal)
        signals[name], said = _measured(placed)
        findings[name].extend(said)
        offset = recording.description.stated_clock_offset(name)
        choices[name] = choose_clock(name, signals[name].stamps, recording.host_clock, offset)
        findings[name].extend(choices[name].findings)
    stored: dict[str, StoredSignal] = {}
    times = {name: choice.t_ns for name, choice in choices.items()}
    kept: dict[str, NDArray[np.bool_]] = {}
    for name, signal in signals.items():
        witnesses = _witnesses(name, signal.stamps, times, cameras, recording)
        judged = judge_steps(name, times[name], signal.values, witnesses)
        kept[name] = judged.kept
        findings[name].extend(judged.findings)
    for name, finding in _shifted({name: times[name][kept[name]] for name in kept}, cameras, recording).items():
        kept[name] = np.zeros_like(kept[name])
        findings[name].append(finding)
    for name, signal in signals.items():
        stored[name], said = _stored(signal, choices[name], kept[name])
        findings[name].extend(said)
    return Timed(stored, tuple(finding for name in findings for finding in findings[name]))


def _shifted(times: Mapping[str, Times], cameras: Mapping[str, Times], recording: Recording) -> dict[str, Finding]:
    """A finding on each signal whose whole clock is off."""
    touches = touched_span(recording, cameras)
    spans = {name: span_of(t_ns) for name, t_ns in (*cameras.items(), *times.items()) if len(t_ns) > 1}
    found = {}
    for name, t_ns in times.items():
        shift = shift_of(name, spans, touches)
        if shift is not None:
            stated = recording.description.clock_offset(name)
            found[name] = shift_finding(name, shift, t_ns, stated, name, LEFT_OUT)
    return found


def _witnesses(
    name: str, stamps: Stamps, times: Mapping[str, Times], cameras: Mapping[str, Times], recording: Recording
) -> list[Witness]:
    """What a signal's time is compared with: its own other stamps, other signals, images, trajectories."""
    found = []
    if stamps.header is not None and len(stamps) and not _is_one_clock(stamps.log - stamps.header):
        found.append(Witness(STAMPS, int(stamps.log[0]), int(stamps.log[-1])))
    for other, t_ns in times.items():
        if other != name and len(t_ns) > 1:
            found.append(witness_of(SIGNAL, t_ns))
    found.extend(witness_of(IMAGES, t_ns) for t_ns in cameras.values() if len(t_ns) > 1)
    if recording.trajectories:
        start = min(trajectory.start_ns for trajectory in recording.trajectories)
        found.append(Witness(TRAJECTORIES, start, max(trajectory.end_ns for trajectory in recording.trajectories)))
    return found


def _is_one_clock(lag: Times) -> bool:
    """Whether log times were made from the header stamps, as converters do: a jump stands in both then."""
    return int(lag.max() - lag.min()) < LEAST_JITTER


def _stored(signal: Signal, choice: ClockChoice, kept: NDArray[np.bool_]) -> tuple[StoredSignal, list[Finding]]:
    placed = np.flatnonzero(kept)
    order, said = time_order(signal.name, choice.t_ns[placed])
    rows: Times = placed if order is None else placed[order]
    t_ns, values = choice.t_ns[rows], signal.values[rows]
    said = (*said, *_rotation_findings(signal, values))
    rate = measure_rate(t_ns, values)
    attributes = {"clock": choice.clock, "shift_ns": choice.shift_ns, **rate.document()}
    stored = StoredSignal(
        t_ns, values, signal.columns, signal.units, signal.frame, signal.stamps.take(rows), attributes
    )
    return stored, [*said, *rate_findings(signal.name, signal.columns, rate)]


def _possible(signal: Signal) -> tuple[Signal, list[Finding]]:
    """The samples whose time a clock can show; the others cannot be placed, nor their distances computed in int64."""
    beyond = np.abs(signal.stamps.log.astype(np.float64)) >= LATEST
    if not beyond.any():
        return signal, []
    text = f"{signal.name}: {int(beyond.sum())} of {len(beyond)} samples have a time beyond the year 2116; left out"
    kept = replace(signal, stamps=signal.stamps.take(~beyond), values=signal.values[~beyond])
    return kept, [Finding("time-impossible", "damage", text, signal.name, count=int(beyond.sum()))]


def _measured(signal: Signal) -> tuple[Signal, list[Finding]]:
    """The samples that a sensor may have given; one with a number beyond ``LARGEST`` is damaged as a whole."""
    columns = [column for column, unit in enumerate(signal.units) if unit in MEASURED_UNITS]
    size = np.abs(signal.values[:, columns])
    is_beyond: NDArray[np.bool_] = np.isfinite(size) & (size > LARGEST)
    beyond: NDArray[np.bool_] = np.asarray(is_beyond.any(axis=1))
    if not beyond.any():
        return signal, []
    row, column = np.argwhere(is_beyond)[0]
    text = (
        f"{signal.name}: {int(beyond.sum())} of {len(beyond)} samples hold a number that no sensor gives (beyond "
        f"{LARGEST:g}; the first is {signal.columns[columns[column]]} = {signal.values[row, columns[column]]:.3g} "
        f"{signal.units[columns[column]]}); left out"
    )
    kept = replace(signal, stamps=signal.stamps.take(~beyond), values=signal.values[~beyond])
    return kept, [Finding("value-impossible", "damage", text, signal.name, count=int(beyond.sum()))]


def _rotation_findings(signal: Signal, values: Values) -> list[Finding]:
    if signal.columns != POSE_COLUMNS:
        return []
    broken = int((broken_rotations(values) & np.isfinite(values).all(axis=1)).sum())
    if not broken:
        return []
    text = f"{signal.name}: {broken} of {len(values)} poses have a quaternion that is no rotation; they are left out"
    return [Finding("rotation-broken", "damage", text, signal.name, count=broken)]


def image_times(recording: Recording, camera: str, stamps: Stamps) -> tuple[Times, dict[str, object], list[Finding]]:
    """Return host times (n,), ns, of one camera's images, the clock and shift that were used, and findings.

    Parameters
    ----------
    recording : Recording
        Its description may state how far the clock of frames is off.
    camera : str
        Name of the camera.
    stamps : Stamps
        Time stamps of its n images, in the order of the recording.
    """
    offset = recording.description.stated_clock_offset("frames")
    choice = choose_clock(camera, stamps, recording.host_clock, offset)
    _, said = time_order(camera, choice.t_ns)
    return choice.t_ns, {"clock": choice.clock, "shift_ns": choice.shift_ns}, [*choice.findings, *said]
