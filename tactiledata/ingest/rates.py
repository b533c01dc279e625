"""At what rate a signal really brings news: runs of equal samples are one measurement read several times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.contract.records import Finding, Times, Values

REPEATS_WORTH_SAYING = 0.05
"""Share of samples equal to the one before, from which on it is reported."""


@dataclass(frozen=True)
class Rate:
    """Rates in Hz over the span of a signal, and its largest gap."""

    nominal: float
    effective: float
    repeated: int
    largest_gap_ns: int

    def document(self) -> dict[str, float | int]:
        """As JSON values."""
        return {
            "rate_hz": round(self.nominal, 3),
            "effective_rate_hz": round(self.effective, 3),
            "repeated_samples": self.repeated,
            "largest_gap_ns": self.largest_gap_ns,
        }


def measure_rate(t_ns: Times, values: Values) -> Rate:
    """Rates of a signal: ``t_ns`` (n,) non-decreasing, ``values`` (n, k)."""
    if len(t_ns) < 2 or t_ns[-1] == t_ns[0]:
        return Rate(0.0, 0.0, 0, 0)
    steps = np.diff(t_ns)
    typical = np.median(steps[steps > 0])
    same = (values[1:] == values[:-1]).all(axis=1)
    repeated = int(same.sum())
    nominal = 1e9 / float(typical)
    return Rate(nominal, nominal * (1 - repeated / len(steps)), repeated, int(steps.max()))


def rate_findings(stream: str, columns: tuple[str, ...], rate: Rate) -> list[Finding]:
    """What is to be said about a signal's rate; only forces always carry noise, an arm at rest does repeat itself."""
    if "fx" not in columns or rate.nominal == 0 or rate.effective > (1 - REPEATS_WORTH_SAYING) * rate.nominal:
        return []
    return [
        Finding(
            "repeated-samples",
            "info",
            f"{stream}: {rate.repeated} samples repeat the one before; recorded at {rate.nominal:.1f} Hz, "
            f"news at {rate.effective:.1f} Hz",
            stream,
            count=rate.repeated,
        )
    ]


def gap_findings(stream: str, t_ns: Times, spans: list[tuple[int, int]], factor: float = 10.0) -> list[Finding]:
    """Gaps inside the given spans (trajectories) that are ``factor`` times the usual distance of samples."""
    if len(t_ns) < 3:
        return []
    steps = np.diff(t_ns)
    limit = max(factor * float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0, 1e6)
    wide = np.flatnonzero(steps > limit)
    inside = [row for row in wide if any(t_ns[row] < end and t_ns[row + 1] > start for start, end in spans)]
    if not inside:
        return []
    largest = max(inside, key=lambda row: steps[row])
    return [
        Finding(
            "gap",
            "warning",
            f"{stream}: {len(inside)} gaps inside trajectories, the largest {steps[largest] / 1e6:.0f} ms",
            stream,
            start_ns=int(t_ns[largest]),
            end_ns=int(t_ns[largest + 1]),
            count=len(inside),
        )
    ]
