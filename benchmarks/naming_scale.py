"""The numbers of `tactiledata.diagnose.evidence_scale`, from cases that `naming_worlds` has run.

    python benchmarks/naming_scale.py FILE.jsonl

A claim needs the least gain with which, all other conditions kept, of 100 nulls at most ``SAID`` are answered with
anything but "nothing is missing"; structure a mean square that one null of 100 reaches. Slope and temperature make the
probabilities of all cases likeliest; a hidden effect whose signal is below three times the noise counts as none.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
from naming_summary import VISIBLE
from scipy.optimize import minimize

from tactiledata.diagnose.decide import NONE, OTHER
from tactiledata.diagnose.evidence_scale import ESTIMATED, EvidenceScale
from tactiledata.diagnose.judge import Judged

Case = dict[str, Any]
SAID = 0.03
"""Share of nulls that may be answered: as a twentieth at most is to be, and other nulls differ."""
LEAST = 5.0
"""Gain that a claim needs whatever the nulls say: a factor of 150 in likelihood."""


def label_of(case: Case) -> str:
    """What a case should be called, of what was considered."""
    if case["signal"] < VISIBLE or not (case["effects"] or case["kind"] == "metadata"):
        return NONE
    names = [" + ".join(one["effects"]) for one in case["candidates"]]
    wanted = [name for name in names if set(name.split(" + ")) == set(case["truth"])]
    return wanted[0] if wanted else OTHER


def odds_of(case: Case, scale: EvidenceScale) -> dict[str, float]:
    """As `tactiledata.diagnose.decide` has them, over the temperature."""
    odds = {
        " + ".join(one["effects"]): scale.slope * (one["gain"] - scale.claim * len(one["effects"]))
        - 2.0 * len(one["implausible"])
        for one in case["candidates"]
    }
    odds[NONE] = 0.0
    odds[OTHER] = scale.other if case["at_large"] > scale.dispersion else -scale.other
    return {name: value / scale.temperature for name, value in odds.items()}


def cost(cases: Sequence[Case], scale: EvidenceScale) -> float:
    """Mean negative logarithm of the probability of what is right; with a little doubt, as no scale is certain."""
    total = 0.0
    for case in cases:
        odds = odds_of(case, scale)
        values = np.array(list(odds.values()))
        shares = np.exp(values - values.max())
        right = float((shares / shares.sum())[list(odds).index(label_of(case))])
        total -= np.log(0.99 * right + 0.01 / len(odds))
    return total / len(cases)


def claim_of(nulls: Sequence[Case]) -> float:
    """The least gain that lets so few nulls be answered."""
    refits = [[judged_of(one) for one in case["candidates"]] for case in nulls]
    for claim in np.arange(LEAST, 100.0, 0.5):
        scale = replace(ESTIMATED, claim=float(claim))
        said = sum(
            any(not one.objections(scale) or one.is_structure(scale) or one.is_trace(scale) for one in judged)
            for judged in refits
        )
        if said <= SAID * len(nulls):
            return float(claim)
    return 100.0


def judged_of(told: dict[str, Any]) -> Judged:
    """A refit as the file tells it; what was fitted is not kept."""
    nothing = float("nan")
    return Judged(
        cast(Any, None), np.array(told["gains"]), told["indenter_gain"] or nothing, told["indenter_error"] or nothing,
        told["excess_share"], *told["signature"], tuple(told["implausible"]), tuple(told["at_bounds"]),
    )  # fmt: skip


def fitted(cases: Sequence[Case]) -> EvidenceScale:
    """The scale that fits the cases."""
    nulls = [case for case in cases if case["kind"] == "nulls"]
    scale = replace(
        ESTIMATED,
        claim=claim_of(nulls),
        dispersion=float(np.quantile([case["at_large"] for case in nulls], 0.99)),
    )

    def at(logs: np.ndarray) -> EvidenceScale:
        slope, temperature, other = (float(value) for value in np.exp(logs))
        return replace(scale, slope=slope, temperature=temperature, other=other)

    start = np.log([ESTIMATED.slope, ESTIMATED.temperature, ESTIMATED.other])
    # a weak pull to the estimates: few cases leave what they do not tell where it is
    found = minimize(
        lambda logs: cost(cases, at(logs)) + 0.01 * float(((logs - start) ** 2).sum()), start, method="Nelder-Mead"
    )
    return at(found.x)


def main() -> None:
    """Print the numbers, and what they make of the probabilities."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path)
    cases = [json.loads(line) for line in parser.parse_args().file.read_text().splitlines()]
    scale = fitted(cases)
    print(f"{len(cases)} cases, {sum(case['kind'] == 'nulls' for case in cases)} of them nulls")
    for name in ("claim", "dispersion", "slope", "temperature", "other"):
        print(f"{name}: {getattr(ESTIMATED, name):.3g} -> {getattr(scale, name):.3g}")
    print(f"mean -log p of what is right: {cost(cases, ESTIMATED):.3f} -> {cost(cases, scale):.3f}")


if __name__ == "__main__":
    main()
