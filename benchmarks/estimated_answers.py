"""Answers from estimated plays beside answers from plays that are all made at finite strain: time, and what differs.

    python benchmarks/estimated_answers.py PROOF [PROOF ...] --keep FOLDER [--kept-answers] [--workers N] [--bank BANK]

A PROOF is a folder that `tactiledata prove --out` made; all have one plan. Its touches are played both ways, each with
an empty cache of its own below FOLDER, and the seconds are printed. Then every case is diagnosed with both, by the code
as it is; with ``--kept-answers`` those from estimated plays are the answers that the proof keeps, from the code that it
names. Listed is every case whose verdict or names differ, and how far E, nu and mu of the plain fit are apart. A run
that was stopped goes on; seconds count only where one run made all plays.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import statistics
import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from timing import header, table

from tactiledata.calibrate.plays.estimated_plays import Estimates
from tactiledata.compute import make_scheduler
from tactiledata.gel.elasticity.compliance import cache_folder
from tactiledata.prove.answers.case_readings import case_readings
from tactiledata.prove.answers.named import named_world
from tactiledata.prove.cases.kinds import NULLS, VISIBLE
from tactiledata.prove.request import ProofRequest
from tactiledata.prove.score.scored_case import ScoredCase
from tactiledata.prove.seal.folder import ProofFolder, read_json
from tactiledata.prove.seal.verify import scored_cases
from tactiledata.prove.worlds.plan_names import named_plan
from tactiledata.prove.worlds.played_plan import PlayedPlan

WAYS: dict[str, Estimates] = {"all made": "none", "estimated": "learned"}
COMPARED = ("verdict", "set", "nearest", "zeros", "before")


@dataclass(frozen=True)
class Answer:
    """A case that is to be diagnosed with plays of one way."""

    way: str
    proof: Path
    case: str
    plan: str
    keep: Path
    bank: Path


def of_way(way: str, plan: str, keep: Path, bank: Path, workers: int = 1) -> PlayedPlan:
    """The plan with plays of one way, kept in a cache of their own."""
    os.environ["TACTILEDATA_CACHE"] = str(keep / way.replace(" ", "-"))
    runner = make_scheduler(workers) if workers > 1 else None
    return PlayedPlan.of(named_plan(plan), bank, with_variants=True, runner=runner, estimates=WAYS[way])


def processor_seconds() -> float:
    """Seconds of processor of this process and of those that it has waited for."""
    spent = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in spent)


def timed(way: str, plan: str, keep: Path, bank: Path, workers: int) -> dict[str, float]:
    """Play the plan in one way; seconds, which are kept beside the plays."""
    file = keep / f"{way.replace(' ', '-')}.json"
    if file.is_file():
        kept: dict[str, float] = json.loads(file.read_text())
        return kept
    is_new = not (keep / way.replace(" ", "-")).exists()
    began, spent = time.perf_counter(), processor_seconds()
    of_way(way, plan, keep, bank, workers)
    spent_here = {"seconds": time.perf_counter() - began, "processor": processor_seconds() - spent, "is_whole": is_new}
    file.write_text(json.dumps(spent_here))
    return spent_here


@cache
def _kept(way: str, plan: str, keep: Path, bank: Path) -> PlayedPlan:
    return of_way(way, plan, keep, bank)


def answered(task: Answer) -> dict[str, Any]:
    """What a diagnosis says of a case."""
    played = _kept(task.way, task.plan, task.keep, task.bank)
    readings = case_readings(ProofFolder(task.proof), task.case)
    return told(task.way, task.case, named_world(played, readings, in_full=False).document)


def told(way: str, case: str, document: dict[str, Any]) -> dict[str, Any]:
    """What is compared of an answer."""
    return {"way": way, "case": case, **{key: document[key] for key in COMPARED}}


def main() -> None:
    """Play, answer and compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("proofs", type=Path, nargs="+")
    parser.add_argument("--keep", type=Path, required=True)
    parser.add_argument("--kept-answers", action="store_true", help="from estimated plays, take those of the proofs")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--bank", type=Path, default=cache_folder() / "generators")
    options = parser.parse_args()
    options.keep.mkdir(parents=True, exist_ok=True)
    folders = [ProofFolder(proof.absolute()) for proof in options.proofs]
    (plan,) = {plan for folder in folders for plan in ProofRequest.of(read_json(folder.proof)["request"]).plans}
    header(f"answers from estimated plays, plan {plan} (simulated recordings)", ("numpy", "scipy", "numba"))
    seconds = {way: timed(way, plan, options.keep, options.bank, options.workers) for way in WAYS}
    whole = seconds["all made"]
    rows = [
        (way, f"{one['seconds']:.0f}", f"{one['processor']:.0f}", f"{one['processor'] / whole['processor']:.2f}")
        for way, one in seconds.items()
    ]
    table(("plays", "s", "s of processors", "ratio"), rows)
    if not all(one["is_whole"] for one in seconds.values()):
        print("A run that made plays was stopped and went on: these seconds are less than all.")
    cases = {case.name: case for folder in folders for case in scored_cases(folder)}
    homes = {case.name: folder.path for folder in folders for case in scored_cases(folder)}
    file = options.keep / "answers.jsonl"
    kept = [json.loads(line) for line in file.read_text().splitlines()] if file.is_file() else []
    if options.kept_answers:
        kept += [told("estimated", name, case.answer) for name, case in cases.items()]
    done = {(one["way"], one["case"]) for one in kept}
    tasks = [
        Answer(way, homes[name], name, plan, options.keep, options.bank)
        for way in WAYS for name in sorted(cases) if (way, name) not in done
    ]  # fmt: skip
    for outcome in make_scheduler(options.workers).outcomes(answered, tasks):
        kept.append(outcome.value)
        with file.open("a") as out:
            out.write(json.dumps(outcome.value) + "\n")
    answers = {(one["way"], one["case"]): one for one in kept}
    compare(answers, {name: case.hidden for name, case in cases.items()})
    print_named(answers, cases)


def in_words(answer: dict[str, Any]) -> str:
    """Verdict and names of an answer, what readings show, and the nearest candidate."""
    names, nearest = (", ".join(found) or "-" for found in (answer["set"] + answer["zeros"], answer["nearest"]))
    return f"{answer['verdict']}: {names} (nearest {nearest})"


def compare(answers: dict[tuple[str, str], dict[str, Any]], hidden: dict[str, str]) -> None:
    """Print how many answers are the same, those that differ, and how far E, nu and mu are apart."""
    same, apart = 0, []
    for name in sorted(hidden):
        made, quick = (answers[way, name] for way in WAYS)
        if all(made[key] == quick[key] for key in ("verdict", "set", "zeros")):
            same += 1
        else:
            both = (f"{way}: {in_words(one)}" for way, one in zip(WAYS, (made, quick), strict=True))
            print(f"{name} ({hidden[name]}): " + "; ".join(both))
        apart.append([b / a - 1 for a, b in zip(made["before"], quick["before"], strict=True)])
    print(f"the same answer: {same} of {len(hidden)}")
    for what, values in zip(("E", "nu", "mu"), zip(*apart, strict=True), strict=True):
        sizes = [100 * abs(value) for value in values]
        print(f"{what} of the plain fit apart: median {statistics.median(sizes):.2f} %, largest {max(sizes):.2f} %")


def print_named(answers: dict[tuple[str, str], dict[str, Any]], cases: dict[str, ScoredCase]) -> None:
    """Print of either way how many visible effects are named, and how many worlds that hide nothing get a name."""
    for way in WAYS:
        names = {name: {*answers[way, name]["set"], *answers[way, name]["zeros"]} for name in cases}
        right = [set(case.label["truth"]) <= names[name] for name, case in cases.items() if case.kind == VISIBLE]
        false = [bool(names[name]) for name, case in cases.items() if case.kind == NULLS]
        print(f"{way}: {sum(right)} of {len(right)} visible effects named, {sum(false)} of {len(false)} nulls")


if __name__ == "__main__":
    main()
