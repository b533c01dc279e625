"""The score of a proof: shares with intervals, who was taken for whom, strength against accuracy, probabilities."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from tactiledata.prove.cases.kinds import (
    ABSORBED,
    AMBIGUOUS,
    CONCEALED,
    DRAWN,
    KINDS,
    LEAST_SIGNAL,
    LOSS_RATIO,
    NULLS,
    OUTSIDE,
    PAIRS,
    VISIBLE,
)
from tactiledata.prove.score.outcome import CLAIMS, FAILED, FALSE_ALARM, IN_SET, NAMED
from tactiledata.prove.score.scored_case import ScoredCase, partly_right
from tactiledata.prove.score.shares import Share, share_of

SIGNALS = (0.0, 8.0, 12.0, 20.0, 40.0, 80.0, np.inf)
"""Signals between which hidden effects are counted together."""
CHANCES = (0.0, 0.5, 0.8, 0.95, 1.0)
"""Probabilities between which answers are counted together."""
SINGLES = (VISIBLE, CONCEALED, AMBIGUOUS, DRAWN)
"""Kinds with one hidden effect of the catalogue."""


@dataclass(frozen=True)
class ProofTarget:
    """A target that was set before the proof was run.

    Parameters
    ----------
    what : str
        What is counted, in words.
    kinds : tuple of str
        Kinds of cases among which is counted.
    counts : callable
        Whether a case counts.
    limit : float
        The share that is aimed at.
    is_most : bool
        Whether the share should be at most the limit; at least otherwise.
    among : callable
        Whether a case of these kinds takes part.
    """

    what: str
    kinds: tuple[str, ...]
    counts: Callable[[ScoredCase], bool]
    limit: float
    is_most: bool = False
    among: Callable[[ScoredCase], bool] = lambda case: True

    def share(self, cases: Sequence[ScoredCase]) -> Share:
        """Return the share among the cases of these kinds that take part."""
        return share_of([case for case in cases if case.kind in self.kinds and self.among(case)], self.counts)

    def document(self, cases: Sequence[ScoredCase]) -> dict[str, Any]:
        """Return the target, its share, and whether it is met; ``None`` where there is no case."""
        share = self.share(cases)
        value = share.value
        met = None if value is None else (value <= self.limit if self.is_most else value >= self.limit)
        bound = "at most" if self.is_most else "at least"
        # certain where the whole interval lies on one side of the limit
        certain = share.high <= self.limit or share.low >= self.limit
        return {
            "what": self.what,
            "target": f"{bound} {100 * self.limit:.0f} %",
            "is_met": met,
            "is_certain": certain,
            **share.document,
        }


TARGETS = (
    ProofTarget("false alarms on nulls", (NULLS,), lambda case: case.outcome == FALSE_ALARM, 0.05, True),
    ProofTarget(
        "wrong names", tuple(kind for kind in KINDS if kind != NULLS), lambda case: case.is_wrong_name, 0.05, True
    ),
    ProofTarget("visible effects named", (VISIBLE,), lambda case: case.outcome == NAMED, 0.80),
    ProofTarget("effects concealed by calibration named", (CONCEALED,), lambda case: case.outcome == NAMED, 0.70),
    # among claims: of effects that nobody named, no set can hold the truth
    ProofTarget(
        "truth in the set of named single effects", SINGLES, lambda case: case.outcome in (NAMED, IN_SET), 0.95,
        among=lambda case: case.answer["verdict"] in CLAIMS,
    ),
    ProofTarget(
        "gap closed on held-out trajectories, where rightly named", (*SINGLES, PAIRS), lambda case: case.closes_gap,
        0.95, among=lambda case: case.is_named_by_fits,
    ),
    ProofTarget("no name outside the catalogue", (OUTSIDE,), lambda case: case.is_right, 0.80),
    ProofTarget("both of a pair named", (PAIRS,), lambda case: case.outcome in (NAMED, IN_SET), 0.60),
    ProofTarget("at least one of a pair named", (PAIRS,), partly_right, 0.90),
    ProofTarget("ambiguous effects answered by a set", (AMBIGUOUS,), lambda case: case.outcome == IN_SET, 0.85),
)  # fmt: skip
"""Targets that were set before any proof was run."""


def met_words(target: Mapping[str, Any]) -> str:
    """Return in words whether a target of a score is met; "so far" where its interval holds the limit as well."""
    if target["is_met"] is None:
        return "no case"
    return ("met" if target["is_met"] else "missed") + ("" if target["is_certain"] else " so far")


def score_of(cases: Sequence[ScoredCase]) -> dict[str, Any]:
    """Return the score of cases and their answers, as ``score.json`` has it.

    Parameters
    ----------
    cases : sequence of ScoredCase
        All cases with an answer.
    """
    claimed = [case for case in cases if case.kind in SINGLES and case.answer["verdict"] in CLAIMS]
    sizes = [len(case.said) for case in claimed]
    return {
        "cases": len(cases),
        "targets": [target.document(cases) for target in TARGETS],
        "outcomes": _outcomes(cases, lambda case: case.kind),
        "by_configuration": _outcomes(cases, lambda case: f"{case.configuration}: {case.kind}"),
        "by_effect": _outcomes([case for case in cases if case.label["hidden"]], lambda case: case.hidden),
        "by_concealment": _outcomes([case for case in cases if case.kind in SINGLES], concealment),
        "confusion": confusion(cases),
        "strength": strength(cases),
        "probabilities": calibration(cases),
        "mean_set": round(float(np.mean(sizes)), 3) if sizes else None,
        "material": material(cases),
        "gap_closed": gap_closed(cases),
        "seconds": round(float(np.median([case.seconds for case in cases])), 2) if cases else None,
        "misses": [case.sentence for case in cases if not case.is_right],
    }


def _outcomes(cases: Sequence[ScoredCase], group: Callable[[ScoredCase], str]) -> dict[str, dict[str, int]]:
    """Return how often each outcome occurs, for each group."""
    found: dict[str, dict[str, int]] = {}
    for case in cases:
        row = found.setdefault(group(case), {})
        row[case.outcome] = row.get(case.outcome, 0) + 1
    return dict(sorted(found.items()))


def concealment(case: ScoredCase) -> str:
    """Return in words whether a single effect can be seen, and whether a calibration conceals it."""
    sight = case.label["sight"]
    if sight["signal"] < LEAST_SIGNAL:
        return "too weak to be seen"
    is_concealed = sight["loss_ratio"] <= LOSS_RATIO or sight["absorbed"] >= ABSORBED
    return "concealed by calibration" if is_concealed else "not concealed"


def confusion(cases: Sequence[ScoredCase]) -> dict[str, dict[str, int]]:
    """Return what was hidden (rows) against what was said (columns); the first name of an answer counts."""
    found: dict[str, dict[str, int]] = {}
    for case in cases:
        row = " + ".join(sorted(case.truth)) or ("nothing" if case.kind == NULLS else f"outside: {case.hidden}")
        names = " + ".join(sorted(case.answer["names"]))
        column = names or (", ".join(case.said) if case.said else f"({case.answer['verdict']})")
        cells = found.setdefault(row, {})
        cells[column] = cells.get(column, 0) + 1
    return dict(sorted(found.items()))


def signal_words(low: float, high: float | None) -> str:
    """Return a range of signals in words; the last range has no end.

    Examples
    --------
    >>> signal_words(8, 12), signal_words(80, None)
    ('8 to 12', '80 and more')
    """
    return f"{low:g} and more" if high is None or high == np.inf else f"{low:g} to {high:g}"


def strength(cases: Sequence[ScoredCase]) -> list[dict[str, Any]]:
    """Return which share of single effects is named, and detected, by the strength of their signals."""
    singles = [case for case in cases if case.kind in SINGLES]
    rows = []
    for low, high in pairwise(SIGNALS):
        inside = [case for case in singles if low <= case.signal < high]
        if inside:
            rows.append({
                "signal": [low, None if high == np.inf else high],
                "named": share_of(inside, lambda case: case.outcome == NAMED).document,
                "named_or_in_set": share_of(inside, lambda case: case.outcome in (NAMED, IN_SET)).document,
                "detected": share_of(inside, lambda case: case.is_detected).document,
            })  # fmt: skip
    return rows


def calibration(cases: Sequence[ScoredCase]) -> dict[str, Any]:
    """Return how often the likeliest answer is right, by its probability, and the expected calibration error (ECE).

    Cases whose diagnosis failed say no probability.
    """
    return calibration_of([case.probability for case in cases if case.outcome != FAILED])


def calibration_of(told: Sequence[tuple[float, bool]]) -> dict[str, Any]:
    """Return how often statements are right, by their probability, and the expected calibration error (ECE).

    Parameters
    ----------
    told : sequence of (probability, whether it is right)
        The statements.
    """
    rows, error = [], 0.0
    for low, high in pairwise(CHANCES):
        inside = [(chance, right) for chance, right in told if low <= chance < high or (high == 1.0 and chance == 1.0)]
        if inside:
            chance = float(np.mean([one[0] for one in inside]))
            right = float(np.mean([one[1] for one in inside]))
            error += len(inside) / len(told) * abs(chance - right)
            rows.append({
                "between": [low, high], "count": len(inside), "mean_probability": round(chance, 4),
                "share_right": round(right, 4),
            })  # fmt: skip
    return {"rows": rows, "ece": round(error, 4) if told else None}


def material(cases: Sequence[ScoredCase]) -> dict[str, Any] | None:
    """Return median absolute errors of E, nu and mu, in %, before and after, of single effects that were named."""
    found = [errors for case in cases if (errors := case.material_errors) is not None]
    if not found:
        return None
    before, after = (np.median(np.abs([one[side] for one in found]), axis=0) for side in (0, 1))
    return {"count": len(found), "before": before.round(2).tolist(), "after": after.round(2).tolist()}


def gap_closed(cases: Sequence[ScoredCase]) -> dict[str, Any] | None:
    """Return which share of the excess over the noise is gone on held-out data, the median over rightly named cases.

    Held out are indenters; trajectories, where indenters cannot be.
    """
    shares = [case.claimed["excess_share"] for case in cases if case.is_named_by_fits and case.claimed is not None]
    return {"count": len(shares), "share": round(float(np.median(shares)), 4)} if shares else None
