"""The zero of a force sensor: stated tare events, or what it reads in free air."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from tactiledata.contract.records import Finding, Times, Values

TOUCH = 0.5
"""N. Change of force against free air that counts as a touch, where the noise is smaller."""

RELEASE_SHARE = 0.5
"""A touch ends when the force falls below this share of the touching threshold."""

MIN_FREE_AIR = 10
"""Samples without contact that a zero is taken from, at least."""

DRIFT_WORTH_SAYING = 0.2
"""N. Range of the zeros of one recording's trajectories, from which on it is reported."""

SURELY_FREE = 0.5
"""Share of the samples before a touch is noticed that is free air for sure: a slow press is under the threshold for as
long as it was in the air, and the median of both was up to 0.1 N off."""

MAX_DRIFT = 5.0
"""N. A trajectory whose start is farther than this from the recording's zero starts in contact, not in free air."""


@dataclass(frozen=True)
class Zero:
    """What was subtracted from a wrench.

    Parameters
    ----------
    bias : (n, 6)
        N and N m, per sample.
    method : str
        In words, for provenance.
    noise : float
        N, standard deviation of one force component in free air.
    findings : tuple of Finding
    """

    bias: Values
    method: str
    noise: float
    findings: tuple[Finding, ...]


def half_sample_mode(samples: Values) -> float:
    """The densest value of samples (n,): the zero of a signal that is at rest more often than at any other level.

    Source: Robertson and Cryer 1974 (half-sample mode); robust where the mean and the median follow the contacts.
    """
    rows = np.sort(samples[np.isfinite(samples)])
    if not len(rows):
        return 0.0
    while len(rows) > 3:
        half = (len(rows) + 1) // 2
        widths = rows[half - 1 :] - rows[: len(rows) - half + 1]
        start = int(np.argmin(widths))
        rows = rows[start : start + half]
    return float(rows.mean())


def component_noise(load: Values) -> float:
    """Standard deviation (N) of one force component, from the differences of neighbouring samples that differ."""
    steps = np.diff(load[:, :3], axis=0)
    steps = steps[(steps != 0).any(axis=1)]
    if not len(steps):
        return 0.0
    return float(np.median(np.abs(steps)) / 0.6745 / np.sqrt(2))


def touching(force: Values, threshold: float) -> np.ndarray:
    """Whether each sample (n,) of a force norm is in contact: above the threshold, until it falls below half of it."""
    above = force > threshold
    below = force < RELEASE_SHARE * threshold
    change = np.where(above, 1, np.where(below, -1, 0))
    known = change != 0
    # every undecided sample takes the state of the last decided one; before any decision there is no contact
    last = np.maximum.accumulate(np.where(known, np.arange(len(change)), -1))
    return np.where(last >= 0, change[np.maximum(last, 0)] > 0, False)


def touch_threshold(noise: float) -> float:
    """N. Six standard deviations of the force norm's noise, at least `TOUCH`."""
    return max(TOUCH, 6.0 * noise * np.sqrt(3))


def find_zero(t_ns: Times, load: Values, spans: list[tuple[str, int, int]], tare_ns: list[int]) -> Zero:
    """The zero of a wrench from which the tool's weight is already taken off.

    Parameters
    ----------
    t_ns : (n,) int64
    load : (n, 6)
        N and N m; weight of the tool subtracted where it is known.
    spans : list of (name, start_ns, end_ns)
        Named trajectories; each is expected to begin in free air.
    tare_ns : list of int
        Stated tare events: the reading was set to zero then, so the zero jumps there.

    Notes
    -----
    Between tare events the zero is the mode of each component; each trajectory then gets the median of its own free air
    before the first touch, because the sensor drifts by newtons within minutes after power-on (see docs/ingest.md).
    """
    noise = component_noise(load[np.isfinite(load).all(axis=1)])
    bias = np.zeros((len(load), 6))
    borders = [0, *np.searchsorted(t_ns, sorted(tare_ns)).tolist(), len(load)]
    for start, stop in itertools.pairwise(borders):
        bias[start:stop] = [half_sample_mode(load[start:stop, axis]) for axis in range(6)]
    findings = _tare_findings(tare_ns, spans)
    if not spans:
        return Zero(bias, "mode of the recording between tare events", noise, tuple(findings))
    missed, zeros = [], []
    for name, start_ns, end_ns in sorted(spans, key=lambda span: span[1]):
        start, stop = np.searchsorted(t_ns, [start_ns, end_ns])
        if start == stop:  # without samples nobody knows where it begins
            continue
        zero = _free_air_zero(load[start:stop], bias[start] if start < len(bias) else np.zeros(6), noise)
        if zero is None:
            missed.append(name)
            continue
        zeros.append(zero)
        bias[start:stop] = zero
    findings.extend(_drift_findings(zeros, missed))
    return Zero(bias, "median of each trajectory's free air before the first touch", noise, tuple(findings))


def _free_air_zero(samples: Values, general: np.ndarray, noise: float) -> np.ndarray | None:
    """Median (6,) of a trajectory's samples (n, 6) before its first touch; ``None`` where there are too few."""
    rows = samples[np.isfinite(samples).all(axis=1)]
    if len(rows) < MIN_FREE_AIR:
        return None
    first = np.median(rows[:MIN_FREE_AIR], axis=0)
    if np.linalg.norm((first - general)[:3]) > MAX_DRIFT:
        return None
    contact = np.flatnonzero(touching(np.linalg.norm((rows - first)[:, :3], axis=1), touch_threshold(noise)))
    free = rows[: contact[0]] if len(contact) else rows
    free = free[: max(MIN_FREE_AIR, int(SURELY_FREE * len(free)))]
    return np.median(free, axis=0) if len(free) >= MIN_FREE_AIR else None


def _tare_findings(tare_ns: list[int], spans: list[tuple[str, int, int]]) -> list[Finding]:
    if not tare_ns:
        text = "wrench: no tare event is stated; the zero is taken from free air"
        return [Finding("zero-from-free-air", "info", text, "wrench")]
    inside = [name for name, start, end in spans if any(start < event < end for event in tare_ns)]
    if not inside:
        return []
    text = (
        f"wrench: a tare event falls inside {len(inside)} trajectories ({', '.join(inside[:5])}); its zero jumps there"
    )
    return [Finding("tare-in-trajectory", "warning", text, "wrench", count=len(inside))]


def _drift_findings(zeros: list[np.ndarray], missed: list[str]) -> list[Finding]:
    findings: list[Finding] = []
    if len(zeros) > 1:
        stack = np.stack(zeros)[:, :3]
        drift = float(np.linalg.norm(stack.max(axis=0) - stack.min(axis=0)))
        if drift > DRIFT_WORTH_SAYING:
            text = f"wrench: its zero moves by {drift:.2f} N over {len(zeros)} trajectories; each has its own zero"
            findings.append(Finding("zero-drift", "info", text, "wrench", count=len(zeros)))
    if missed:
        text = (
            f"wrench: {len(missed)} trajectories do not begin in free air ({', '.join(missed[:5])}"
            f"{' …' if len(missed) > 5 else ''}); the zero before them was kept"
        )
        findings.append(Finding("no-free-air", "warning", text, "wrench", count=len(missed)))
    return findings
