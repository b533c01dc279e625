"""The cases of a sealed proof by other methods: a BIC ladder, sparse regression, learned discrepancies, and nothing.

    python benchmarks/proof_rivals.py PROOF [--out FILE.jsonl] [--cases N] [--methods NAME ...] [--bank FOLDER]

PROOF is a folder that `tactiledata prove --out` made and answered; our answers are those that it keeps. Each method
sees the readings of a case, as our diagnosis did, and says names or none. All of them, ours too, also say what readings
without contact show by themselves, but for the drift that every world has: "nothing (recalibration)" says no more. An
answer is right where it names nothing of a null or of what no catalogue holds, and where what is hidden is shown by
readings, or among the first two of its names. Differences are paired: the same cases by both, with the 95 % interval
of a bootstrap over cases.

"ours, simulation exact" is no rival: it is our diagnosis of readings from which the generator's own error is taken off,
which only the oracle of the proof knows. What it misses by the rules in use is lost to something else than that error.
With ``--out`` a run that was stopped goes on.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rival_methods import Case, bic_ladder, boosted_trees, gaussian_process, ours, sparse_regression
from timing import header, table

from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.gel.elasticity.compliance import cache_folder
from tactiledata.prove.answers.case_readings import case_readings
from tactiledata.prove.cases.configuration import Configuration, played_plan
from tactiledata.prove.cases.drawn_world import DrawnWorld
from tactiledata.prove.cases.kinds import NULLS, OUTSIDE
from tactiledata.prove.cases.oracle import with_wrenches
from tactiledata.prove.request import ProofRequest
from tactiledata.prove.score.outcome import CLAIMS
from tactiledata.prove.score.scored_case import ScoredCase
from tactiledata.prove.seal.folder import ProofFolder, read_json
from tactiledata.prove.seal.verify import scored_cases
from tactiledata.prove.worlds.played_plan import START, PlayedPlan

METHODS: dict[str, Callable[[Case], tuple[str, ...]]] = {
    "BIC ladder": bic_ladder,
    "sparse regression (pysindy)": sparse_regression,
    "Gaussian process": gaussian_process,
    "boosted trees": boosted_trees,
    "nothing (recalibration)": lambda case: (),
}
EXACT = "ours, simulation exact"
"""Our diagnosis of readings from which the generator's error is taken off."""
DRAWS = 10_000
"""Number of bootstrap samples."""


def is_right(kind: str, truth: frozenset[str], said: Sequence[str], shown: Sequence[str] = ()) -> bool:
    """Whether an answer is right: no name where there is none to give, else all that is hidden is in it.

    What is hidden has to be among the first two names that are said, or among those that readings show.
    """
    if kind in (NULLS, OUTSIDE):
        return not said and not shown
    return bool(truth) and truth <= {*said[: max(2, len(truth))], *shown}


def judged(cases: Sequence[ScoredCase], kept: Sequence[dict[str, Any]]) -> dict[str, list[tuple[str, bool, bool]]]:
    """Return, by method, a row for each case that it answered: kind, whether its answer is right, whether ours is."""
    by_name = {case.name: case for case in cases}
    found: dict[str, list[tuple[str, bool, bool]]] = {}
    for one in kept:
        case = by_name[one["case"]]
        shown = case.answer["zeros"]
        said = case.answer["set"] if case.answer["verdict"] in CLAIMS else ()
        row = (
            case.kind,
            is_right(case.kind, case.truth, one["said"], shown),
            is_right(case.kind, case.truth, said, shown),
        )
        found.setdefault(one["method"], []).append(row)
    return found


def exact_case(case: ScoredCase, played: PlayedPlan, touches: TouchSet, effects: Sequence[str]) -> Case:
    """The case as a simulation would see it that errs by nothing where nothing is hidden."""
    label = case.label
    world = DrawnWorld(played, Configuration(**label["configuration"]), label["seed"])
    measured = np.concatenate([one.measured for one in touches.touches])
    return Case(with_wrenches(touches, measured - world.solver_error), START, effects)


def difference(ours: Sequence[bool], other: Sequence[bool], seed: int = 0) -> tuple[float, float, float]:
    """Share in which ours is right less that of another method, and its 95 % interval by a bootstrap over cases."""
    apart = np.array(ours, dtype=float) - np.array(other, dtype=float)
    drawn = np.random.default_rng(seed).integers(len(apart), size=(DRAWS, len(apart)))
    low, high = np.quantile(apart[drawn].mean(axis=1), [0.025, 0.975])
    return float(apart.mean()), float(low), float(high)


def show(found: dict[str, list[tuple[str, bool, bool]]]) -> None:
    """A row for each method, with our answers to the same cases beside it."""
    kinds = sorted({kind for rows in found.values() for kind, _, _ in rows})
    rows = []
    for method, answers in found.items():
        apart, low, high = difference([ours for _, _, ours in answers], [right for _, right, _ in answers])
        shares = []
        for kind in kinds:
            of_kind = [(right, ours) for one, right, ours in answers if one == kind]
            shares.append(f"{sum(one for one, _ in of_kind)} ({sum(one for _, one in of_kind)}) of {len(of_kind)}")
        rows.append((method, *shares, f"{100 * apart:+.0f} [{100 * low:+.0f}, {100 * high:+.0f}]"))
    table(("method: right (ours)", *kinds, "ours less it, points [95 %]"), rows)


def main() -> None:
    """Answer what is not in the file yet, then show the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("proof", type=Path)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--cases", type=int, help="only so many, in the order of their random names")
    parser.add_argument("--methods", nargs="*", choices=[*METHODS, EXACT], default=[*METHODS, EXACT])
    parser.add_argument("--bank", type=Path, default=cache_folder() / "generators")
    options = parser.parse_args()
    folder = ProofFolder(options.proof)
    request = ProofRequest.of(read_json(folder.proof)["request"])
    cases = scored_cases(folder)[: options.cases]
    lines = options.out.read_text().splitlines() if options.out and options.out.is_file() else []
    chosen = {case.name for case in cases}
    kept = [one for one in map(json.loads, lines) if one["case"] in chosen and one["method"] in options.methods]
    done = {(one["case"], one["method"]) for one in kept}
    header("a sealed proof by other methods (simulated recordings)", ("numpy", "scipy", "scikit-learn", "pysindy"))
    for case in cases:
        todo = [method for method in options.methods if (case.name, method) not in done]
        if not todo:
            continue
        played = played_plan(case.label["configuration"]["plan"], options.bank, request.with_variants)
        readings = case_readings(folder, case.name)
        touches = played.maker.cases(played.maker.observed(readings), played.family)
        seen = Case(touches, START, played.effects)
        for method in todo:
            said = ours(exact_case(case, played, touches, seen.effects)) if method == EXACT else METHODS[method](seen)
            kept.append({"case": case.name, "method": method, "said": list(said)})
            print(f"{case.name} ({case.kind}: {case.hidden}): {method}: {', '.join(said) or 'nothing'}", flush=True)
            if options.out:
                with options.out.open("a") as file:
                    file.write(json.dumps(kept[-1]) + "\n")
    show(judged(cases, kept))


if __name__ == "__main__":
    main()
