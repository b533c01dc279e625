"""Missing physics named in development worlds: another solver presses and hides effects in formulas of its own, our gel
engine is the simulation that lacks them.

    python benchmarks/naming_worlds.py [--quick] [--plan N] [--mounts M] [--cases all] [--count K] [--out FILE.jsonl]
                                       [--bank FOLDER]

Cases: `nulls`, `effects` (each of the rig's, in the catalogue), `outside` of it, `pairs`, `metadata` (an indenter whose
radius is not what the log says). The *signal* of what is hidden: the root of the squares, in units of the noise, that
the plain simulation leaves of it when it is refitted to wrenches without noise.

A plan of touches is the same in all its cases, so that what the gel engine played (TACTILEDATA_CACHE) and what the
rig's layer solver answered (--bank) serve all of them; what is not there yet is solved first, which takes an hour.
Cases that the file holds already are not run again. Clocks of the logs are right.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from naming_asked import KINDS, Asked, asked_cases
from naming_summary import summary

from tactiledata.diagnose.naming.metric import cosines
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.effects import EFFECTS
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.prove.answers.named import named_world
from tactiledata.prove.cases.oracle import refit
from tactiledata.prove.cases.truth import friction_left, modulus_left
from tactiledata.prove.worlds.plan import WorldPlan
from tactiledata.prove.worlds.played_plan import PlayedPlan
from tactiledata.rig.scenario.scenario import load_scenario


@dataclass(frozen=True)
class Bench(PlayedPlan):
    """Cases of one plan, run one after the other.

    Parameters
    ----------
    plan, maker, family, effects, plays
        See `PlayedPlan`.
    pairs : bool
        Whether pairs of effects are tried.
    in_full : bool
        Whether gels on which the answer could rest are played in full.
    """

    pairs: bool = True
    in_full: bool = True
    _kept: dict[tuple[int, GelMaterial], np.ndarray] = field(default_factory=dict)

    def felt(self, asked: Asked, truth: GelMaterial) -> np.ndarray:
        """Wrenches of the world with what it hides, without noise."""
        if not (asked.hidden or asked.more):
            return self.clean(asked.seed, truth)
        exact = self.maker.recorded(asked.seed, truth, asked.hidden, asked.more, is_exact=True)
        return np.concatenate(exact.wrenches)

    def clean(self, seed: int, truth: GelMaterial) -> np.ndarray:
        """Wrenches of the world without what it hides, without noise; those of the last seed are kept."""
        if (seed, truth) not in self._kept:
            self._kept.clear()
            clean = self.maker.recorded(seed, truth, [], is_exact=True)
            self._kept[seed, truth] = np.concatenate(clean.wrenches)
        return self._kept[seed, truth]

    def run(self, asked: Asked) -> dict[str, Any]:
        """One case from the rig to the answer."""
        truth = self.gel(asked.seed)
        readings = self.maker.readings(asked.seed, truth, asked.hidden, asked.more)
        began = time.perf_counter()
        named = named_world(self, readings, self.pairs, self.in_full)
        seconds = time.perf_counter() - began
        cases = named.touch_set
        scenario = load_scenario(self.maker.plan.scenario(asked.seed, truth, asked.hidden))
        change, left, unhidden = np.zeros((int(cases.counts.sum()), 6)), 0.0, truth
        if asked.hidden or asked.more:
            felt, clean = self.felt(asked, truth), self.clean(asked.seed, truth)
            plain, change = refit(cases, clean), felt - clean
            left, unhidden = refit(cases, felt).cost - plain.cost, plain.model.material
        return {
            "case": asked.label,
            **{key: value for key, value in asdict(asked).items() if key != "wrong"},
            "truth": list(asked.truth),
            "material": asdict(truth),
            "modulus_left": modulus_left(scenario.hidden),
            "friction_left": friction_left(scenario.hidden, truth.friction),
            "unhidden": asdict(unhidden),
            "seconds": round(seconds, 2),
            **named.document,
            **_beside(named.naming, asked, change),
            "signal": round(float(np.sqrt(max(left, 0.0))), 2),
        }


def _beside(naming: NamingResult, asked: Asked, change: np.ndarray) -> dict[str, Any]:
    """What is kept beside the answer; ``to_first_order`` is the hidden change beyond what a linear refit imitates."""
    metric = naming.base.metric
    field_ = naming.whitened.whiten(change)
    signal = float(np.sqrt(max(metric.cost(field_), 0.0)))
    best = naming.decision.best
    known = naming.identifiable
    reach = {
        name: max((float(r) for n, r in zip(known.effects, known.reach, strict=True) if n == name), default=0.0)
        for name in asked.truth
    }
    return {
        "errors": naming.base.model.errors.round(2).tolist(),
        "to_first_order": round(signal, 2),
        "cosine": float(cosines(metric, [field_, best.fit.effect_change])[0, 1]) if best and signal > 0 else None,
        "reach": reach,
    }


def _tell(done: int, total: int, what: str = "") -> None:
    print(f"# the gel: {done} of {total} batches {what}", flush=True)


def keep_and_tell(case: Asked, result: dict[str, Any], out: Path | None) -> None:
    """Append what was found of a case to a file, where there is one, and print it in a line."""
    if out:
        with out.open("a") as file:
            file.write(json.dumps(result) + "\n")
    said = f"{result['verdict']}: {', '.join(result['set']) or '-'} (nearest {' + '.join(result['nearest'])})"
    readings = sorted(set(result["zeros"]))
    said += f", of readings alone {', '.join(readings)}" if readings else ""
    print(f"{case.label}: {said}; signal {result['signal']:.0f}; {result['seconds']:.0f} s", flush=True)


def main() -> None:
    """Run what is not in the file yet; print a line a case, then the summary."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="ten touches on a coarse linear pad; shows that it works")
    parser.add_argument("--plan", type=int, default=0)
    parser.add_argument("--mounts", type=int, default=5, help="of each of the five indenters, a touch each")
    parser.add_argument("--cases", choices=(*KINDS, "all"), default="all")
    parser.add_argument("--count", type=int, default=1)
    parser.add_argument("--strength", choices=("weak", "medium", "strong"), default="medium")
    parser.add_argument("--without-variants", action="store_true", help="leave out effects that need other gels played")
    parser.add_argument("--varied", nargs="*", default=list(EFFECTS), help="of these, the ones to be played")
    parser.add_argument("--only", nargs="*", help="of the rig's effects")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--bank", type=Path, default=Path(tempfile.gettempdir()) / "tactiledata-rig-bank")
    options = parser.parse_args()
    cases = asked_cases(KINDS if options.cases == "all" else (options.cases,), options.count, options.strength)
    if options.only:
        cases = [one for one in cases if set(one.effects) & set(options.only)]
    if options.quick:
        cases = [one for one in cases if one.kind == "nulls" or one.effects == ("frame_rotation",)]
    lines = options.out.read_text().splitlines() if options.out and options.out.is_file() else []
    found = [json.loads(line) for line in lines]
    asked_plan = {"plan": options.plan, "mounts": options.mounts}
    done = {one["case"] for one in found if {name: one.get(name, 5) for name in asked_plan} == asked_plan}
    todo = [one for one in cases if one.label not in done]
    with_variants = not (options.quick or options.without_variants)
    plan = WorldPlan(options.plan, options.quick, options.mounts)
    bench = Bench.of(plan, options.bank, with_variants, options.varied, None, _tell) if todo else None
    for one in todo:
        assert bench is not None
        result = {**asked_plan, **bench.run(one)}
        found.append(result)
        keep_and_tell(one, result, options.out)
    print(summary(found))


if __name__ == "__main__":
    main()
