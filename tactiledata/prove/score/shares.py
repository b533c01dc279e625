"""Shares with intervals: Wilson's, which takes cases as independent, and a bootstrap over configurations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactiledata.prove.score.scored_case import ScoredCase
from tactiledata.prove.score.wilson import interval

DRAWS = 2000
"""Number of draws of a bootstrap."""


@dataclass(frozen=True)
class Share:
    """A share of cases.

    Parameters
    ----------
    right : int
        Number of cases that count.
    count : int
        Number of all cases.
    low, high : float
        Wilson's 95 % interval.
    low_over_configurations, high_over_configurations : float, optional
        95 % interval of a bootstrap over configurations; ``None`` where there are fewer than three.
    """

    right: int
    count: int
    low: float
    high: float
    low_over_configurations: float | None
    high_over_configurations: float | None

    @property
    def value(self) -> float | None:
        """The share; ``None`` of no case."""
        return self.right / self.count if self.count else None

    @property
    def document(self) -> dict[str, Any]:
        """The share for a score."""
        value = self.value
        apart = (self.low_over_configurations, self.high_over_configurations)
        return {
            "right": self.right,
            "count": self.count,
            "share": None if value is None else round(value, 4),
            "interval": [round(self.low, 4), round(self.high, 4)],
            "over_configurations": [round(end, 4) for end in apart if end is not None] or None,
        }

    @property
    def words(self) -> str:
        """The share in words."""
        if not self.count:
            return "no case"
        ends = interval_words((self.low, self.high))
        return f"{self.right} of {self.count} ({100 * self.right / self.count:.0f} %, {ends})"


def interval_words(ends: Sequence[float] | None) -> str:
    """Return the interval of a share in percent; an empty text where there is none."""
    return "" if ends is None else f"{100 * max(0.0, ends[0]):.0f} to {100 * ends[1]:.0f} %"


def share_of(cases: Sequence[ScoredCase], counts: Callable[[ScoredCase], bool], seed: int = 0) -> Share:
    """Return the share of cases that count.

    Parameters
    ----------
    cases : sequence of ScoredCase
        All cases.
    counts : callable
        Whether a case counts.
    seed : int
        Seed of the bootstrap.
    """
    flags = [bool(counts(case)) for case in cases]
    low, high = interval(sum(flags), len(flags))
    groups: dict[str, list[bool]] = {}
    for case, flag in zip(cases, flags, strict=True):
        groups.setdefault(case.configuration, []).append(flag)
    ends: tuple[float | None, float | None] = (None, None)
    if len(groups) >= 3:
        right = np.array([sum(group) for group in groups.values()])
        total = np.array([len(group) for group in groups.values()])
        drawn = np.random.default_rng(seed).integers(len(groups), size=(DRAWS, len(groups)))
        shares = right[drawn].sum(axis=1) / total[drawn].sum(axis=1)
        found = np.quantile(shares, [0.025, 0.975])
        ends = float(found[0]), float(found[1])
    return Share(sum(flags), len(flags), low, high, *ends)
