"""The next trial recorded and added: does the trial that a diagnosis proposes turn an answer without a name into one?

    python benchmarks/next_trial_loop.py [--generator layer|analytic|element] [--plan wedge-2] [--mismatch SIZE]
                                         [--effects ageing_friction ...] [--seed N] [--out FILE.jsonl] [--bank FOLDER]

A world hides one effect that can be seen. It is diagnosed; the trial that the diagnosis puts first is recorded by the
same generator in the same world; plan and trial together are diagnosed again. Answers are from estimated plays. A line
is printed for each world, and then how many of those that were not named at first are named with the trial. Worlds that
the file holds already are not run again. Everything is simulated.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np

from tactiledata.diagnose.next_trial.bench import TrialBench
from tactiledata.diagnose.next_trial.propose import propose_trials
from tactiledata.diagnose.next_trial.trial import Trial
from tactiledata.gel.elasticity.compliance import cache_folder
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.prove.answers.named import NamedWorld, named_world
from tactiledata.prove.cases.configuration import Configuration, played_plan
from tactiledata.prove.cases.draw import CaseRequest, drawn_case
from tactiledata.prove.cases.kinds import VISIBLE
from tactiledata.prove.cases.world_case import WorldCase
from tactiledata.prove.score.outcome import IN_SET, NAMED, outcome
from tactiledata.prove.worlds.generators import GENERATORS
from tactiledata.prove.worlds.plan import ENOUGH, UNITS
from tactiledata.prove.worlds.plan_names import named_plan
from tactiledata.prove.worlds.played_plan import PlayedPlan
from tactiledata.prove.worlds.wedges import WedgePlan

FRICTIONS = ("ageing_friction", "shear_strength", "partial_slip", "rate_friction", "static_friction")
"""Hidden effects, by the rig's names, that plans of short moves hardly show."""
STOPS = 10
"""Stops on each way of a trial that is filmed: worlds have frames where the arm stops."""


@dataclass(frozen=True)
class FollowedPlan(WedgePlan):
    """A plan, and a trial on its first unit after it.

    Parameters
    ----------
    number, is_quick, mounts, count
        See `WedgePlan`.
    trial : tuple of dict
        The trial's touches, as a scenario has them.
    shapes : dict, name -> document
        Indenters of the trial.
    """

    trial: tuple[Mapping[str, Any], ...] = ()
    shapes: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, plan: WedgePlan, trial: Trial, bench: TrialBench) -> FollowedPlan:
        """Return a plan with a trial after it."""
        touches = tuple(
            {
                "name": f"{UNITS[0]}-{trial.name}-{number}",
                "sensor": UNITS[0],
                "indenter": touch.indenter,
                "position": list(touch.position),
                "force_limit": ENOUGH,
                "steps": [_with_stops(step) if trial.capture == "video" else dict(step) for step in touch.steps],
            }
            for number, touch in enumerate(trial.touches)
        )
        shapes = {touch.indenter: dict(bench.indenter(touch.indenter).document) for touch in trial.touches}
        kept = {one.name: getattr(plan, one.name) for one in fields(plan)}
        return cls(**kept, trial=touches, shapes=shapes)

    @property
    def touches(self) -> list[dict[str, Any]]:
        """The touches of the plan, and then those of the trial."""
        return [*super().touches, *(dict(touch) for touch in self.trial)]

    def scenario(self, seed: int, material: GelMaterial, hidden: list[dict[str, Any]]) -> dict[str, Any]:
        """Return the scenario of a world of this plan, as a document; see `WorldPlan.scenario`.

        Parameters
        ----------
        seed, material, hidden
            See `WorldPlan.scenario`.
        """
        document = super().scenario(seed, material, hidden)
        return {**document, "indenters": {**self.shapes, **document["indenters"]}}


def _with_stops(step: Mapping[str, Any]) -> dict[str, Any]:
    """Return a step whose way has stops for frames."""
    kind, numbers = next(iter(step.items()))
    if kind == "press":
        return {kind: {**numbers, "step": numbers["depth"] / STOPS}}
    if kind == "shear":
        return {kind: {**numbers, "step": float(np.hypot(*numbers["by"])) / STOPS}}
    return dict(step)


def told(named: NamedWorld, truth: Sequence[str]) -> dict[str, Any]:
    """Return what is kept of an answer: verdict, set, whether it is right, and the evidence for the truth."""
    document = named.document
    found = [one for one in document["candidates"] if set(one["effects"]) == set(truth)]
    best = max(found, key=lambda one: one["evidence"], default=None)
    # what readings show by themselves is no merit of the trial
    worth = outcome({**document, "truth": truth, "zeros": (), "signal": 0.0})
    return {
        "verdict": document["verdict"],
        "set": document["set"],
        "nearest": document["nearest"],
        "right": worth in (NAMED, IN_SET) and len(document["set"]) <= 2,
        "evidence": None if best is None else round(best["evidence"], 1),
        "needed": None if best is None else round(best["needed"], 1),
    }


def followed(case: WorldCase, plan: WedgePlan, first: NamedWorld, bank: Path) -> dict[str, Any]:
    """Return the trial that a first answer proposes, and the answer to plan and trial together."""
    proposals = propose_trials(first.naming)
    if not proposals:
        return {"trial": None}
    best = proposals[0]
    longer = FollowedPlan.of(plan, best.trial, best.bench)
    played = PlayedPlan.of(longer, bank, with_variants=True)
    maker = case.configuration.maker(played.maker)
    readings = maker.readings(case.seed, GelMaterial(*case.material), [dict(one) for one in case.hidden])
    second = named_world(played, readings, in_full=False)
    rivals = sorted({name for pair in best.separations for name in (pair.first, pair.second)})
    return {"trial": best.trial.name, "rivals": rivals, "second": told(second, case.truth)}


def run(request: CaseRequest) -> dict[str, Any] | None:
    """Return what one world came to; None where no draw of the effect can be seen."""
    began = time.perf_counter()
    drawn = drawn_case(request)
    if drawn.case is None:
        return None
    plan = named_plan(request.configuration.plan)
    assert isinstance(plan, WedgePlan)
    first = named_world(played_plan(request.configuration.plan, request.bank, True), drawn.readings, in_full=False)
    row = {
        "number": request.number,
        "hidden": [dict(one) for one in drawn.case.hidden],
        "truth": list(drawn.case.truth),
        "signal": drawn.case.document["sight"]["signal"],
        "first": told(first, drawn.case.truth),
    }
    if not row["first"]["right"]:
        row |= followed(drawn.case, plan, first, request.bank)
    return {**row, "seconds": round(time.perf_counter() - began)}


def line(row: Mapping[str, Any]) -> str:
    """Return a world in a line of a table."""

    def said(answer: Mapping[str, Any]) -> str:
        names = ", ".join(answer["set"]) or answer["verdict"]
        evidence = "" if answer["evidence"] is None else f" ({answer['evidence']:g} of {answer['needed']:g})"
        return f"{names}{', right' if answer['right'] else ''}{evidence}"

    second = said(row["second"]) if "second" in row else "–"
    trial = row.get("trial") or "–"
    return f"| {row['hidden'][0]['effect']} | {row['signal']:.1f} | {said(row['first'])} | {trial} | {second} |"


def main() -> None:
    """Run the worlds that are asked for; print a line for each, and how many got a right name by the trial."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--generator", choices=tuple(GENERATORS), default="layer")
    parser.add_argument("--plan", default="wedge-2")
    parser.add_argument("--mismatch", type=float, default=0.0)
    parser.add_argument("--effects", nargs="+", default=list(FRICTIONS), help="by the rig's names")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("next-trial-loop.jsonl"))
    parser.add_argument("--bank", type=Path, default=cache_folder() / "generators")
    options = parser.parse_args()
    rows = [json.loads(text) for text in options.out.read_text().splitlines()] if options.out.exists() else []
    print("| hidden | signal | first answer | trial | answer with the trial |\n|---|---|---|---|---|")
    for number, effect in enumerate(options.effects):
        row = next((one for one in rows if one["number"] == number), None)
        if row is None:
            configuration = Configuration(options.generator, options.plan, options.mismatch, options.seed)
            row = run(CaseRequest(number, VISIBLE, configuration, options.seed, options.bank, True, (effect,)))
            if row is None:
                print(f"| {effect} | no draw can be seen | | | |", flush=True)
                continue
            rows.append(row)
            with options.out.open("a") as file:
                file.write(json.dumps(row) + "\n")
        print(line(row), flush=True)
    open_ones = [row for row in rows if "second" in row]
    right = sum(row["second"]["right"] for row in open_ones)
    print(f"\n{len(rows) - len(open_ones)} of {len(rows)} worlds need no trial, or none is proposed.")
    print(f"{right} of {len(open_ones)} others are rightly named with the trial (in a set of at most two).")


if __name__ == "__main__":
    main()
