"""The numbers of `tactiledata.diagnose.naming.thresholds`, from cases that `naming_worlds` has run.

    python benchmarks/naming_scale.py FILE.jsonl

A claim needs the least gain with which, all other conditions kept, of 100 nulls at most ``SAID`` are answered with
anything but "nothing found"; structure a mean square that one null of 100 reaches. The scale of probabilities
makes those of all cases likeliest; a hidden effect whose signal is below what a claim needs counts as none, as does one
that only the zeros tell, and what is outside the catalogue is left out. A drift of the sensor, which every world has,
is right beside what is hidden. The probabilities that stand in the package are held against how often they are right.
"""

from __future__ import annotations

import argparse
import itertools
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np
from naming_summary import of_nulls
from numpy.typing import NDArray
from scipy.optimize import minimize

from tactiledata.diagnose.naming.evidence import ScoredCandidate
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS, DecisionThresholds
from tactiledata.prove.cases.kinds import LEAST_SIGNAL
from tactiledata.prove.score.outcome import CLAIMS

Array = NDArray[np.float64]
Case = dict[str, Any]
POSITIVE = ("evidence_slope", "unclaimed_cost")
"""Numbers of the scale whose logarithms are fitted."""
ODDS = ("log_odds_nothing", "log_odds_nothing_beside_structure")
"""Numbers of the scale that are fitted as they are."""
EVERYWHERE = frozenset({"sensor_drift"})
"""What every world of the rig has a little of."""
EDGES = (0.0, 0.5, 0.8, 0.95, 1.01)
"""Of probabilities, between which answers are counted."""


@dataclass(frozen=True)
class Considered:
    """What was considered in a case: c candidates, then another effect beside one, none and other.

    Parameters
    ----------
    beyond : (c,)
        Evidence beyond what a claim needs.
    is_claimed : (c,) bool
    names : c sets of str
        Effects of each candidate.
    right : places of what should be said
    at_large : float
        Mean square of what is left.
    """

    beyond: Array
    is_claimed: NDArray[np.bool_]
    names: list[frozenset[str]]
    right: tuple[int, ...]
    at_large: float

    @staticmethod
    def of(case: Case) -> Considered:
        """Of a case as the file tells it."""
        told = case["candidates"]
        names = [frozenset(one["effects"]) for one in told]
        judged = [judged_of(one) for one in told]
        thresholds = thresholds_of(case)
        claimed = frozenset(case["names"] if case["verdict"] in CLAIMS else ())
        in_set = {claimed, *(frozenset([name]) for name in case["set"])} if claimed else set()
        beyond = np.array([one.share_of_need(thresholds) for one in judged])
        is_claimed = np.array([one in in_set for one in names], dtype=bool)
        return Considered(beyond, is_claimed, names, _right(case, names), case["at_large"])

    def shares(self, scale: DecisionThresholds) -> Array:
        """Probabilities (c + 3,)."""
        is_left = self.at_large > scale.structure_dispersion
        return scale.shares(self.beyond, self.is_claimed, self.names, is_left)


def thresholds_of(case: Case) -> DecisionThresholds:
    """The thresholds for the data of a case, from what its first candidate needs."""
    if not case["candidates"]:
        return DEFAULT_THRESHOLDS
    one = case["candidates"][0]
    grown = DEFAULT_THRESHOLDS.for_data(1)
    # needed evidence is linear in the number of trajectories times their precision
    at_none, at_one = DEFAULT_THRESHOLDS.needed(one["effects"]), grown.needed(one["effects"])
    return replace(grown, data=(one["needed"] - at_none) / (at_one - at_none))


def _right(case: Case, names: Sequence[frozenset[str]]) -> tuple[int, ...]:
    """Places of what should be said."""
    hidden = frozenset(case["truth"]) - (frozenset(case["zeros"]) if len(case["truth"]) > 1 else frozenset())
    beside, nothing, other = range(len(names), len(names) + 3)
    is_shown = case["signal"] >= LEAST_SIGNAL and bool(case["truth"])
    if not is_shown or hidden <= frozenset(case["zeros"]):
        # errors of the solver are in no catalogue, and they are there
        return nothing, other
    found = tuple(place for place, one in enumerate(names) if hidden <= one and one - hidden <= EVERYWHERE)
    return found or ((beside,) if any(one < hidden for one in names) else (other,))


def cost(cases: Sequence[Considered], scale: DecisionThresholds) -> float:
    """Mean negative logarithm of the probability of what is right; with a little doubt, as no scale is certain."""
    told = [one.shares(scale) for one in cases]
    right = np.array([shares[list(one.right)].sum() for shares, one in zip(told, cases, strict=True)])
    return float(-np.mean(np.log(0.99 * right + 0.01 / np.array([len(shares) for shares in told]))))


@dataclass(frozen=True)
class Told:
    """What the file keeps of a fit."""

    names: tuple[str, ...]


def judged_of(told: dict[str, Any]) -> ScoredCandidate:
    """A refit as the file tells it; what was fitted is not kept."""
    nothing = float("nan")
    return ScoredCandidate(
        cast(Any, Told(tuple(told["effects"]))), np.array(told["gains"]), told["indenter_gain"] or nothing,
        told["indenter_error"] or nothing,
        told["excess_share"], *told["signature"], tuple(told["implausible"]), tuple(told["at_bounds"]),
        told["evidence"], np.array(told["falls"]), told.get("error_size", 1.0),
    )  # fmt: skip


def fitted(cases: Sequence[Case]) -> DecisionThresholds:
    """The scale of probabilities that fits the cases."""

    def at(values: np.ndarray) -> DecisionThresholds:
        numbers = [*np.exp(values[: len(POSITIVE)]).tolist(), *values[len(POSITIVE) :].tolist()]
        return replace(DEFAULT_THRESHOLDS, **dict(zip((*POSITIVE, *ODDS), numbers, strict=True)))

    now = [[getattr(DEFAULT_THRESHOLDS, name) for name in names] for names in (POSITIVE, ODDS)]
    start = np.concatenate([np.log(now[0]), now[1]])
    # a weak pull to the estimates: few cases leave what they do not tell where it is
    told = [Considered.of(case) for case in cases]
    found = minimize(
        lambda values: cost(told, at(values)) + 0.01 * float(((values - start) ** 2).sum()), start, method="Powell"
    )
    return at(found.x)


def held_out_cost(cases: Sequence[Case], folds: int = 4) -> float:
    """The cost of cases by a scale that was fitted to the others."""
    dealt = np.random.default_rng(0).permutation(len(cases)) % folds
    costs = [
        cost(
            [Considered.of(case) for case, one in zip(cases, dealt, strict=True) if one == fold],
            fitted([case for case, one in zip(cases, dealt, strict=True) if one != fold]),
        )
        for fold in range(folds)
    ]
    return float(np.average(costs, weights=np.bincount(dealt)))


def _likeliest(case: Considered, shares: Array) -> tuple[float, bool]:
    """Probability of the likeliest candidate, or of no known effect where that is likelier; and whether it is right."""
    unknown = float(shares[-2:].sum())
    best = int(shares[:-3].argmax()) if len(shares) > 3 else -1
    if best < 0 or unknown >= shares[best]:
        return unknown, len(shares) - 2 in case.right
    return float(shares[best]), best in case.right


def reliability(cases: Sequence[Considered], scale: DecisionThresholds) -> list[tuple[str, int, float, float]]:
    """Of the likeliest answers: between which probabilities, how many, their mean probability, share that is right."""
    shares = [one.shares(scale) for one in cases]
    told = [_likeliest(one, each) for one, each in zip(cases, shares, strict=True)]
    rows = []
    for low, high in itertools.pairwise(EDGES):
        inside = [(chance, is_right) for chance, is_right in told if low <= chance < high]
        if inside:
            chances, rights = zip(*inside, strict=True)
            rows.append(
                (f"{low:g} to {min(high, 1.0):g}", len(inside), float(np.mean(chances)), float(np.mean(rights)))
            )
    return rows


def main() -> None:
    """Print the numbers, and what they make of the probabilities."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path)
    cases = [json.loads(line) for line in parser.parse_args().file.read_text().splitlines()]
    cases = [case for case in cases if case["kind"] != "outside"]
    told = [Considered.of(case) for case in cases]
    scale = fitted(cases)
    print(f"{len(cases)} cases, {sum(case['kind'] == 'nulls' for case in cases)} of them nulls")
    nulls = [case for case in cases if case["kind"] == "nulls"]
    print("largest evidence of an effect in a null, without its two best trajectories, and needed:")
    for name, evidence, of_others, needed in of_nulls(nulls):
        print(f"    {name}: {evidence:.1f}, {of_others:.1f}, {needed:.0f}")
    most = float(np.quantile([case["at_large"] for case in nulls], 0.99))
    in_use = DEFAULT_THRESHOLDS.structure_dispersion
    print(f"mean square that nulls leave at large, 99 of 100: {most:.3g} (in use {in_use:g})")
    for name in (*POSITIVE, *ODDS):
        print(f"{name}: {getattr(DEFAULT_THRESHOLDS, name):.3g} -> {getattr(scale, name):.3g}")
    print(f"mean -log p of what is right: {cost(told, DEFAULT_THRESHOLDS):.3f} -> {cost(told, scale):.3f}")
    print(f"the same of cases by a scale that was fitted to others: {held_out_cost(cases):.3f}")
    print("probability of the likeliest answer: cases, mean probability, share that is right")
    for what, count, chance, right in reliability(told, DEFAULT_THRESHOLDS):
        print(f"    {what}: {count}, {chance:.2f}, {right:.2f}")


if __name__ == "__main__":
    main()
