"""What the cases of `naming_worlds` come to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.prove.score.outcome import CLAIMS, outcome
from tactiledata.prove.score.wilson import interval

Array = NDArray[np.float64]
Case = dict[str, Any]


def of_nulls(nulls: Sequence[Case]) -> list[tuple[str, float, float, float]]:
    """Return each effect with the most evidence in a null, the most without its two best trajectories, and the need."""
    most: dict[str, list[float]] = {}
    for case in nulls:
        for one in case["candidates"]:
            if len(one["effects"]) == 1:
                here = most.setdefault(one["effects"][0], [-np.inf, -np.inf, one["needed"]])
                here[0], here[1] = max(here[0], one["evidence"]), max(here[1], one["evidence_of_others"])
    rows = [(name, *values) for name, values in most.items()]
    return sorted(rows, key=lambda row: -row[1])


def summary(cases: Sequence[Case]) -> str:
    """Everything, in lines."""
    lines = []
    nulls = [case for case in cases if case["kind"] == "nulls"]
    if nulls:
        said = [case for case in nulls if case["verdict"] != "nothing found" or case["zeros"]]
        lines.append(f"\nnulls: {len(nulls)}, answers other than 'nothing found': {len(said)}")
        lines += [f"    {case['case']}: {case['verdict']} {case['set'] or case['nearest']}" for case in said]
        gains = [max((one["gain"] for one in case["candidates"]), default=0.0) for case in nulls]
        ends = np.quantile(gains, [0.5, 0.95, 1.0]).round(1)
        lines.append(f"    largest held-out gain of a null: median {ends[0]}, 95 % {ends[1]}, most {ends[2]}")
        named = sum(case["verdict"] in CLAIMS or bool(case["zeros"]) for case in nulls)
        low, high = interval(named, len(nulls))
        lines.append(f"    named: {named} of {len(nulls)} (95 % interval {100 * low:.0f} to {100 * high:.0f} %)")
        lines.append("    largest evidence of an effect in a null, without its two best trajectories, and needed:")
        for name, evidence, of_others, needed in of_nulls(nulls):
            lines.append(f"        {name}: {evidence:.1f}, {of_others:.1f}, {needed:.0f}")
        left = np.quantile([case["dispersion"] for case in nulls], [0.5, 0.95]).round(2)
        lines.append(f"    mean square left of held-out trajectories: median {left[0]}, 95 % {left[1]}")
    for kind in ("effects", "pairs", "outside", "metadata"):
        lines += _kind(kind, [case for case in cases if case["kind"] == kind])
    lines += _material(cases)
    if cases:
        lines.append(f"\nseconds a case: median {np.median([case['seconds'] for case in cases]):.0f}")
    return "\n".join(lines)


def _kind(kind: str, cases: Sequence[Case]) -> list[str]:
    if not cases:
        return []
    found = [outcome(case) for case in cases]
    counts = ", ".join(f"{name} {found.count(name)}" for name in dict.fromkeys(found))
    sizes = [len(case["set"]) for case in cases if case["verdict"] in CLAIMS]
    size = f"; mean set {np.mean(sizes):.2f}" if sizes else ""
    lines = [f"\n{kind}: {len(cases)}: {counts}{size}"]
    for case, one in zip(cases, found, strict=True):
        said = ", ".join(case["set"]) or f"nearest {' + '.join(case['nearest']) or '-'}"
        lines.append(f"    {case['case']}: {one} ({case['verdict']}: {said}; signal {case['signal']:.0f})")
    return lines


def _material(cases: Sequence[Case]) -> list[str]:
    """Errors of E, nu, mu of nulls and of single effects that were claimed rightly; without a claim nothing changes.

    The latter also against what the same calibration finds in the world without its effect: that leaves out what the
    two solvers differ in. Under relaxation E is what is left of it after a touch, as effects/relaxation.py has it, and
    mu is that of the speed, or pressure, at which effects of friction have it.
    """
    lines = []
    for what, chosen, reference in (
        ("nulls", [case for case in cases if case["kind"] == "nulls"], "material"),
        ("effects named or in the set", _claimed(cases), "material"),
        ("the same, against a calibration of the world without the effect", _claimed(cases), "unhidden"),
    ):
        if not chosen:
            continue
        off = np.abs([_off(case, reference) for case in chosen])
        for share, name in ((0.5, "median"), (0.9, "90 %")):
            ends = np.quantile(off, share, axis=0).round(1)
            lines.append(f"|error| of E, nu, mu in %, {name} of {what}: before {ends[0]}, after {ends[1]}")
    return ["", *lines, *_each_material(_claimed(cases))] if lines else []


def _each_material(cases: Sequence[Case]) -> list[str]:
    """A line a case: E, nu, mu against a calibration of the world without the effect."""
    lines = []
    for case in cases:
        before, after = (", ".join(f"{one:+.1f}" for one in off) for off in _off(case, "unhidden"))
        lines.append(f"    {case['case']}: {before} % before, {after} % after")
    return lines


def _off(case: Case, reference: str) -> Array:
    """Errors (2, 3) of E, nu, mu, before and after, in %."""
    truth = np.array(list(case[reference].values())) * [case["modulus_left"], 1.0, case.get("friction_left", 1.0)]
    after = case["after" if case["verdict"] in CLAIMS else "before"]
    errors: Array = 100 * (np.array([case["before"], after]) / truth - 1)
    return errors


def _claimed(cases: Sequence[Case]) -> list[Case]:
    return [case for case in cases if case["kind"] == "effects" and outcome(case) in ("named", "in the set")]
