"""Print which effects a diagnosis names where they follow laws that neither the rig nor the catalogue has.

    python benchmarks/laws_named.py --plan wedge-13 [--generator layer] [--mismatch 0,1] [--seed 1] [--workers N]
        [--json FILE]

In each world one of `laws.LAWS` is hidden, at a strength that is drawn until it can be seen: a signal of at least 8
after the plain simulation is refitted. What counts as right is what counts in a proof. Laws that are in no catalogue
should get no name. Plays and solutions are kept where `tactiledata prove` keeps them; a run that is stopped goes on
from the file of ``--json``.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from laws import LAWS, Law
from timing import header, table

from tactiledata.compute import make_scheduler
from tactiledata.contract.atomic import write_json_atomic
from tactiledata.gel.elasticity.compliance import cache_folder
from tactiledata.prove.answers.named import named_world
from tactiledata.prove.cases.configuration import Configuration, played_plan
from tactiledata.prove.cases.drawn_world import DrawnWorld
from tactiledata.prove.cases.kinds import LEAST_SIGNAL, OUTSIDE, VISIBLE
from tactiledata.prove.cases.oracle import refit
from tactiledata.prove.score.outcome import IN_SET, NAMED
from tactiledata.prove.score.scored_case import ScoredCase

TRIES = 16
"""Largest number of strengths that are drawn for one world."""


@dataclass(frozen=True)
class Asked:
    """A world that is to be recorded and diagnosed."""

    law: int
    configuration: Configuration
    seed: int
    bank: Path

    @property
    def name(self) -> str:
        """The world in a few words."""
        return f"{LAWS[self.law].__name__}, {self.configuration.label}, seed {self.seed}"


def diagnosed(asked: Asked) -> dict[str, Any]:
    """Return what is hidden in a world, and what its diagnosis says."""
    kind = LAWS[asked.law]
    played = played_plan(asked.configuration.plan, asked.bank, True)
    chance = np.random.default_rng([asked.seed, asked.law, int(asked.configuration.mismatch)])
    world = DrawnWorld(played, asked.configuration, int(chance.integers(2**31)))
    recorder, gel = asked.configuration.maker(played.maker), played.gel(world.seed)
    found: dict[str, Any] = {"name": asked.name, "law": kind.__name__, "effect": kind.EFFECT}
    for _ in range(TRIES):
        hidden: Law = kind(float(np.exp(chance.uniform(*np.log(kind.DRAWN)))))
        exact = recorder.readings(world.seed, gel, [], (hidden,), is_exact=True)
        felt = np.concatenate(played.maker.observed(exact).wrenches)
        signal = float(np.sqrt(max(refit(world.touch_set, felt).cost - world.plain.cost, 0.0)))
        if signal >= LEAST_SIGNAL:
            break
    else:
        return {**found, "outcome": "too weak to be seen"}
    readings = recorder.readings(world.seed, gel, [], (hidden,))
    answer = named_world(played, readings, pairs=True, in_full=False).document
    label = {
        "kind": VISIBLE if kind.EFFECT else OUTSIDE,
        "configuration": asked.configuration.document,
        "hidden": [{"effect": kind.__name__}],
        "truth": [kind.EFFECT] if kind.EFFECT else [],
        "sight": {"signal": signal},
    }
    case = ScoredCase(asked.name, label, answer, 0.0)
    return {
        **found,
        "strength": hidden.strength,
        "signal": signal,
        "verdict": answer["verdict"],
        "said": list(case.said),
        "nearest": answer["nearest"],
        "against": list(answer["objections"][:2]),
        "outcome": case.outcome,
    }


def print_tables(worlds: list[dict[str, Any]]) -> None:
    """Print a line a world, then how many effects of the catalogue are named, and how many others get a name."""
    rows = [
        (
            one["law"], one["effect"] or "-", f"{one['signal']:.0f}", one["verdict"], ", ".join(one["said"]) or "-",
            " + ".join(one["nearest"]) or "-", one["outcome"],
        )
        for one in worlds if "signal" in one
    ]  # fmt: skip
    table(("law", "effect", "signal", "verdict", "said", "nearest", "outcome"), rows)
    seen = [one for one in worlds if "signal" in one]
    mine = [one for one in seen if one["effect"]]
    named = sum(one["outcome"] in (NAMED, IN_SET) for one in mine)
    wrong = sum(one["outcome"] == "wrong" for one in mine)
    others = sum(bool(one["said"]) for one in seen if not one["effect"])
    print(f"Effects of the catalogue by other laws: {named} of {len(mine)} named, {wrong} with a wrong name.")
    print(f"Effects outside the catalogue: {others} of {len(seen) - len(mine)} get a name.")
    print(f"Too weak to be seen at any strength that was drawn: {len(worlds) - len(seen)}.")


def main() -> None:
    """Diagnose a world of each law and configuration, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plan", default="wedge-13")
    parser.add_argument("--generator", default="layer")
    parser.add_argument("--mismatch", default="0,1")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--bank", type=Path, default=cache_folder() / "generators")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    header("effects by laws that neither rig nor catalogue has (simulated recordings)", ("numpy", "scipy", "numba"))
    asked = [
        Asked(law, Configuration(given.generator, given.plan, float(mismatch), given.seed), given.seed, given.bank)
        for law in range(len(LAWS))
        for mismatch in given.mismatch.split(",")
    ]
    kept = (
        {one["name"]: one for one in json.loads(given.json.read_text())} if given.json and given.json.exists() else {}
    )
    todo = [one for one in asked if one.name not in kept]
    for outcome in make_scheduler(given.workers).outcomes(diagnosed, todo, len(todo)):
        one = outcome.value
        kept[one["name"]] = one
        print(f"{one['name']}: {one['outcome']}", flush=True)
        if given.json:
            write_json_atomic(given.json, [kept[each.name] for each in asked if each.name in kept])
    print_tables([kept[one.name] for one in asked])


if __name__ == "__main__":
    main()
