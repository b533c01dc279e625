"""At what rate a signal really changes: a short run of equal samples is one measurement read several times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.contract.records import Finding, Times, Values
from tactiledata.contract.wording import agreeing, counted

REPEATS_WORTH_SAYING = 0.05
"""Share of samples equal to the one before, from which on it is reported."""

STILL = 500_000_000
"""ns. A longer run of equal samples is a robot at rest, and says nothing about the rate of its measurements."""


@dataclass(frozen=True)
class Rate:
    """Rates of a signal and its largest gap.

    Parameters
    ----------
    nominal : float
        Hz, at which samples come.
    effective : float
        Hz, at which their values change while the signal is not at rest; 0 where it never changes.
    repeated, steps : int
        How many samples are equal to the one before, of how many.
    largest_gap_ns : int
    """

    nominal: float
    effective: float
    repeated: int
    steps: int
    largest_gap_ns: int

    def document(self) -> dict[str, float | int]:
        """The rate as JSON values."""
        return {
            "rate_hz": round(self.nominal, 3),
            "effective_rate_hz": round(self.effective, 3),
            "repeated_samples": self.repeated,
            "largest_gap_ns": self.largest_gap_ns,
        }


def measure_rate(t_ns: Times, values: Values) -> Rate:
    """Rates of a signal: ``t_ns`` (n,) non-decreasing, ``values`` (n, k)."""
    if len(t_ns) < 2 or t_ns[-1] == t_ns[0]:
        return Rate(0.0, 0.0, 0, 0, 0)
    steps = np.diff(t_ns)
    nominal = 1e9 / float(np.median(steps[steps > 0]))
    changed = np.flatnonzero((values[1:] != values[:-1]).any(axis=1))
    # samples from one change to the next; those of a long rest are left out
    runs, lasted = np.diff(changed), np.diff(t_ns[changed + 1])
    moving = runs[lasted <= STILL]
    effective = nominal * len(moving) / moving.sum() if len(moving) else 0.0
    return Rate(nominal, float(effective), len(steps) - len(changed), len(steps), int(steps.max()))


def rate_findings(stream: str, columns: tuple[str, ...], rate: Rate) -> list[Finding]:
    """Return a finding on repeated samples of a force signal; none for other signals and where few samples repeat.

    Only forces always carry noise, whereas an arm at rest does repeat itself.

    Parameters
    ----------
    stream : str
        Name of the signal, for the finding.
    columns : tuple of str
        Names of its columns; a signal of forces has ``fx``.
    rate : Rate
        How often its samples come, and how many of them repeat the one before.
    """
    if "fx" not in columns or rate.repeated < REPEATS_WORTH_SAYING * rate.steps or not rate.repeated:
        return []
    if rate.repeated == rate.steps:
        text = (
            f"{stream}: all {rate.steps + 1} samples are the same, and a force sensor always shows some noise: it was "
            "not read, and what follows from it says nothing. Check the sensor and its driver"
        )
        return [Finding("force-stuck", "warning", text, stream, count=rate.steps + 1)]
    changing = rate.nominal * (1 - rate.repeated / rate.steps)
    return [
        Finding(
            "repeated-samples",
            "info",
            f"{stream}: {counted(rate.repeated, 'sample')} {agreeing(rate.repeated, 'repeats', 'repeat')} the one "
            f"before; recorded at {rate.nominal:.1f} Hz, "
            f"new values at {changing:.1f} Hz",
            stream,
            count=rate.repeated,
        )
    ]


def gap_findings(stream: str, t_ns: Times, spans: list[tuple[int, int]], factor: float = 10.0) -> list[Finding]:
    """Return a finding on the gaps of a stream inside trajectories; none where there are no gaps.

    A gap is longer than ``factor`` times the usual distance of samples, and than 1 ms. Of one that reaches beyond a
    trajectory, only what lies inside counts: pauses between trajectories are no gaps.

    Parameters
    ----------
    stream : str
        Name of the stream, for the finding.
    t_ns : (n,) int64 ns
        Host times of its samples, ascending.
    spans : list of (int, int) ns
        Start and end of each trajectory.
    factor : float
        Shortest gap in units of the median distance of samples.
    """
    if len(t_ns) < 3:
        return []
    steps = np.diff(t_ns)
    limit = max(factor * float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0, 1e6)
    lost = [
        (int(max(t_ns[row], start)), int(min(t_ns[row + 1], end)))
        for row in np.flatnonzero(steps > limit)
        for start, end in spans
    ]
    inside = [(start, end) for start, end in lost if end - start > limit]
    if not inside:
        return []
    start, end = max(inside, key=lambda gap: gap[1] - gap[0])
    text = f"{stream}: {counted(len(inside), 'gap')} inside trajectories, the largest {(end - start) / 1e6:.0f} ms"
    return [Finding("gap", "warning", text, stream, start_ns=start, end_ns=end, count=len(inside))]
