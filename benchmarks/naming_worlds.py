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
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from naming_asked import KINDS, Asked, asked_cases
from naming_case import Maker, to_play
from naming_plan import Plan
from naming_summary import DRIFT, summary
from naming_truth import friction_left, modulus_left

from tactiledata.diagnose.answer.sentences import Answer
from tactiledata.diagnose.naming.full_plays import FullPlay, named_with_full_plays
from tactiledata.diagnose.naming.joint_fit import JointFit, plain_fit
from tactiledata.diagnose.naming.metric import cosines
from tactiledata.diagnose.naming.name_effects import NamingResult, name_effects
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
from tactiledata.diagnose.touches.grid_answer import TouchPlays
from tactiledata.diagnose.touches.play_grid import play_touches
from tactiledata.diagnose.touches.played_response import PlayedFamily
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.variant_plays import design_variants, variants_of
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.diagnose.zeros.causes import zero_causes
from tactiledata.effects import EFFECTS
from tactiledata.effects.touch.response import GelVariant
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import Fidelity
from tactiledata.rig.scenario.scenario import load_scenario

START = GelMaterial(0.9e6, 0.475, 0.65)
QUICK_EFFECTS = ("frame_rotation", "relaxation", "lag")


@dataclass(frozen=True)
class _Played:
    """Touches of a case with the plays by which they are simulated."""

    touch_set: TouchSet
    plays: list[TouchPlays]


@dataclass
class Bench:
    """Cases of one plan, run one after the other."""

    plan: Plan
    maker: Maker
    family: PlayedFamily
    effects: tuple[str, ...]
    plays: Callable[[frozenset[GelVariant]], list[TouchPlays]]
    pairs: bool = True
    in_full: bool = True
    _kept: tuple[tuple[int, GelMaterial], np.ndarray] | None = None

    @staticmethod
    def of(plan: Plan, bank: Path, with_variants: bool, varied: Iterable[str] = tuple(EFFECTS)) -> Bench:
        """Everything that all cases share; what was not played yet is played, and ``varied`` effects' other gels."""
        maker = Maker.of(plan, bank)
        fidelity: Fidelity = "linear" if plan.is_quick else "finite-strain"
        wanted = variants_of(varied) if with_variants else ()
        touches = to_play(maker.touches)

        @cache
        def plays_with(full: frozenset[GelVariant]) -> list[TouchPlays]:
            return play_touches(plan.mesh, fidelity, touches, plan.bounds, None, _tell, wanted, full=full)

        plays = plays_with(frozenset())
        known = [one.known for one in plays]
        played = set(plays[0].variants)
        asked = QUICK_EFFECTS if plan.is_quick else EFFECTS
        tried = tuple(name for name in asked if played.issuperset(design_variants(EFFECTS[name]())))
        maker = maker.keeping(known)

        def known_plays(full: frozenset[GelVariant]) -> list[TouchPlays]:
            return [one.part(rows) for one, rows in zip(plays_with(full), known, strict=True)]

        return Bench(plan, maker, PlayedFamily(maker.touches, known_plays(frozenset())), tried, known_plays)

    def gel(self, seed: int) -> GelMaterial:
        """Of a world: E is its own."""
        modulus = float(np.random.default_rng([seed, 53]).uniform(0.84e6, 0.95e6))
        return GelMaterial(modulus, self.plan.truth.poisson_ratio, self.plan.truth.friction)

    def felt(self, asked: Asked, truth: GelMaterial) -> np.ndarray:
        """Wrenches of the world with what it hides, without noise."""
        if not (asked.hidden or asked.more):
            return self.clean(asked.seed, truth)
        exact = self.maker.recorded(asked.seed, truth, asked.hidden, asked.more, is_exact=True)
        return np.concatenate(exact.wrenches)

    def clean(self, seed: int, truth: GelMaterial) -> np.ndarray:
        """Wrenches of the world without what it hides, without noise; those of the last seed are kept."""
        if self._kept is None or self._kept[0] != (seed, truth):
            clean = self.maker.recorded(seed, truth, [], is_exact=True)
            self._kept = (seed, truth), np.concatenate(clean.wrenches)
        return self._kept[1]

    def run(self, asked: Asked) -> dict[str, Any]:
        """One case from the rig to the answer."""
        truth = self.gel(asked.seed)
        recorded = self.maker.recorded(asked.seed, truth, asked.hidden, asked.more)
        cases = self.maker.cases(recorded, self.family)
        began = time.perf_counter()
        options = NamingOptions(effects=self.effects, profile=False, pairs=self.pairs)

        def play(full: frozenset[GelVariant]) -> _Played:
            plays = self.plays(full)
            return _Played(replace(cases, base=PlayedFamily(self.maker.touches, plays)), plays)

        def name(played: _Played) -> NamingResult:
            return name_effects(played.touch_set, START, options)

        full_plays: tuple[FullPlay, ...] = ()
        if self.in_full:
            _, naming, full_plays = named_with_full_plays(play, name, DEFAULT_THRESHOLDS)
        else:
            naming = name(play(frozenset()))
        seconds = time.perf_counter() - began
        scenario = load_scenario(self.maker.plan.scenario(asked.seed, truth, asked.hidden))
        change, left, unhidden = np.zeros((int(cases.counts.sum()), 6)), 0.0, truth
        if asked.hidden or asked.more:
            felt, clean = self.felt(asked, truth), self.clean(asked.seed, truth)
            plain, change = _refit(cases, clean), felt - clean
            left, unhidden = _refit(cases, felt).cost - plain.cost, plain.model.material
        return {
            "case": asked.label,
            **{key: value for key, value in asdict(asked).items() if key != "wrong"},
            "truth": list(asked.truth),
            "material": asdict(truth),
            "modulus_left": modulus_left(scenario.hidden),
            "friction_left": friction_left(scenario.hidden, truth.friction),
            "unhidden": asdict(unhidden),
            "seconds": round(seconds, 2),
            "zeros": [*(cause.effect for cause in zero_causes(recorded.zeros)), *recorded.shown],
            **_found(naming, asked, change),
            "signal": round(float(np.sqrt(max(left, 0.0))), 2),
            "full_plays": [asdict(one) for one in full_plays],
        }


def _refit(cases: TouchSet, wrenches: np.ndarray) -> JointFit:
    """The plain simulation fitted to wrenches (N, 6) without noise; its cost in squares of the noise."""
    ends = np.cumsum(cases.counts)[:-1]
    exact = [replace(case, measured=one) for case, one in zip(cases.touches, np.split(wrenches, ends), strict=True)]
    return plain_fit(WhitenedTouches.of(replace(cases, touches=exact), NamingOptions().errors), START)


def _found(naming: NamingResult, asked: Asked, change: np.ndarray) -> dict[str, Any]:
    """What is kept of an answer; ``to_first_order`` is the hidden change beyond what a linear refit imitates."""
    answer = Answer(naming)
    metric = naming.base.metric
    field_ = naming.whitened.whiten(change)
    signal = float(np.sqrt(max(metric.cost(field_), 0.0)))
    best = naming.decision.best
    known = naming.identifiable
    ranked = sorted(naming.scored, key=lambda each: -each.gain)
    reach = {
        name: max((float(r) for n, r in zip(known.effects, known.reach, strict=True) if n == name), default=0.0)
        for name in asked.truth
    }
    document = answer.document
    kept = ("verdict", "names", "probabilities", "objections", "dispersion", "at_large", "undetectable", "not_tried")
    return {
        **{key: document[key] for key in kept},
        "set": list(answer.candidates),
        "nearest": list(best.names) if best else [],
        "ties": [tie.name for tie in naming.decision.ties],
        "candidates": [
            {**told, "gains": one.gains.round(2).tolist(), "falls": one.evidence_per_trajectory.round(2).tolist()}
            for told, one in zip(document["candidates"], ranked, strict=True)
        ],
        "screen": document["screen"][:10],
        "before": [one["value"] for one in document["before"]],
        "after": [one["value"] for one in document["after"][:3]],
        "values": {one["name"]: one["value"] for one in document["after"][3:]},
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
    readings = sorted(set(result["zeros"]) - {DRIFT})
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
    plan = Plan(options.plan, options.quick, options.mounts)
    bench = Bench.of(plan, options.bank, with_variants, options.varied) if todo else None
    for one in todo:
        assert bench is not None
        result = {**asked_plan, **bench.run(one)}
        found.append(result)
        keep_and_tell(one, result, options.out)
    print(summary(found))


if __name__ == "__main__":
    main()
