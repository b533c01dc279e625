"""Three stories of concealed physics, and one in which nothing is: what calibration hides, what its loss cannot see.

    python benchmarks/stories.py [arm_compliance] [relaxation] [frame_rotation] [nothing] [--pictures docs/images]

Each is a world of benchmarks/naming_worlds.py: the rig's layer solver presses 25 touches (more with --mounts) and
conceals one effect in a formula of its own; the gel engine is the simulation that lacks it. It is calibrated as the
SPLIT paper does, by the norm of the force, then diagnosed; intervals are those of the likelihood's curvature. What the
gel played (TACTILEDATA_CACHE) and what the rig solved (--bank) serve all stories, and the other benchmarks of naming;
what is not there yet takes an hour first.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from naming_worlds import Bench
from story_pictures import Numbers, draw_story

from tactiledata.calibrate.experiment import Experiment, assemble
from tactiledata.calibrate.fit import fit
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.calibrate.plan import ResponsePlan
from tactiledata.calibrate.plays.player import play_nodes
from tactiledata.calibrate.remarks import remarks
from tactiledata.contract.atomic import write_atomic
from tactiledata.diagnose.answer.naming_page import naming_page, naming_sentences
from tactiledata.diagnose.naming.intervals import ProfiledInterval
from tactiledata.diagnose.naming.name_effects import name_effects
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.unseen.compare import show
from tactiledata.effects.simulate.setting import write_settings
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.nuisance.noise import WrenchNoise
from tactiledata.prove.cases.truth import RELAXED_AFTER, modulus_left
from tactiledata.prove.worlds.plan import WorldPlan
from tactiledata.prove.worlds.played_plan import START
from tactiledata.prove.worlds.recorder import WorldMaker
from tactiledata.prove.worlds.touches import to_play
from tactiledata.report.plots import png_bytes
from tactiledata.rig.scenario.scenario import load_scenario

STORIES = {
    "nothing": [],
    "arm_compliance": [{"effect": "arm_compliance", "strength": "medium"}],
    "relaxation": [{"effect": "relaxation", "strength": "medium"}],
    "frame_rotation": [{"effect": "frame_rotation", "strength": "medium"}],
}
TRUTH = 0.9e6
"""Pa; nu and mu are the plan's."""
SEED = 7000


def tell(story: str, bench: Bench, maker: WorldMaker, out: Path, pictures: Path | None) -> None:
    """Record, calibrate, diagnose; page, effects and picture go to folders."""
    plan = bench.plan
    truth = GelMaterial(TRUTH, plan.truth.poisson_ratio, plan.truth.friction)
    known = (truth.youngs_modulus, truth.poisson_ratio, truth.friction)
    cases = bench.maker.cases(bench.maker.recorded(SEED, truth, STORIES[story]), bench.family)
    print(f"\n## {story}: {len(cases.touches)} touches; truth {_words(known)}")
    left = modulus_left(load_scenario(plan.scenario(SEED, truth, STORIES[story])).hidden)
    if left < 1.0:
        known = (left * truth.youngs_modulus, *known[1:])
        print(f"of which E is {known[0] / 1e3:.0f} kPa after {RELAXED_AFTER:.0f} s: the truth of a relaxed gel")
    experiment = _experiment(plan, maker, truth, story)
    numbers = [_calibrated(experiment, cases.touches[0].noise, plan)]
    began = time.process_time()
    naming = name_effects(cases, START, NamingOptions(effects=bench.effects, profile=False))
    shown = show(naming)
    print(f"diagnosed in {time.process_time() - began:.0f} s of the processor")
    for sentence in naming_sentences(naming, shown.located, shown):
        print(f"- {sentence}")
    numbers.append(_fitted("plain fit", naming.intervals_before))
    out.mkdir(parents=True, exist_ok=True)
    write_atomic(out / f"{story}.html", naming_page(f"A story: {story}", naming, shown.located, shown).encode())
    best = naming.decision.best
    if shown.names and best is not None:
        numbers.append(_fitted("with the effect", naming.intervals))
        write_settings(best.fit.model.settings, out / f"{story}-effects.json", best.fit.model.material)
    if pictures is not None:
        pictures.mkdir(parents=True, exist_ok=True)
        picture = png_bytes(draw_story(numbers, known, naming, shown), 90)
        write_atomic(pictures / f"story-{story.replace('_', '-')}.png", picture)


def _fitted(title: str, found: Sequence[ProfiledInterval]) -> Numbers:
    """E, nu and mu of a fit of whole wrenches."""
    return Numbers(title, tuple(one.value for one in found[:3]), tuple((one.low, one.high) for one in found[:3]))


def _experiment(plan: WorldPlan, maker: WorldMaker, truth: GelMaterial, story: str) -> Experiment:
    """The same recording as a calibration takes it."""
    recorded = maker.recorded(SEED, truth, STORIES[story])
    touches = [
        replace(touch, wrench=wrench, free_samples=float(len(free)))
        for touch, wrench, free in zip(to_play(maker.touches), recorded.interpolated, recorded.free, strict=True)
    ]
    nodes = ResponsePlan.of(plan.bounds)
    plays = play_nodes(plan.mesh, _options(plan).mechanics, touches, list(nodes.nodes()))
    found = assemble(touches, nodes, plays)
    assert isinstance(found, Experiment)
    return found


def _options(plan: WorldPlan) -> CalibrationOptions:
    return CalibrationOptions(loss="norm", fidelity="linear" if plan.is_quick else "finite-strain", hold_out=0.0)


def _calibrated(experiment: Experiment, noise: WrenchNoise, plan: WorldPlan) -> Numbers:
    """What a calibration by the paper's loss says, printed."""
    options = _options(plan)
    found = fit(experiment, noise, plan.bounds, options)
    print(f"calibrated by the norm: {_words(found.parameters)}; loss {found.losses['norm'].fitted:.3f} N")
    for one in remarks(found, plan.bounds, options.offset_prior, {}, False, options.shape_share):
        print(f"  {one.severity} {one.code}: {one.message}", flush=True)
    return Numbers("paper's loss", tuple(float(value) for value in found.parameters))


def _words(parameters: Sequence[float] | np.ndarray) -> str:
    modulus, ratio, friction = parameters
    return f"E {modulus / 1e3:.0f} kPa, nu {ratio:.3f}, mu {friction:.3f}"


def main() -> None:
    """Tell the stories that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stories", nargs="*", metavar="STORY", help=f"of {', '.join(STORIES)}; all of them by default")
    parser.add_argument("--quick", action="store_true", help="ten touches on a coarse linear pad; shows that it works")
    parser.add_argument("--without-variants", action="store_true", help="leave out effects that need other gels played")
    parser.add_argument("--mounts", type=int, default=5, help="of each of the five indenters, a touch each")
    parser.add_argument("--bank", type=Path, default=Path(tempfile.gettempdir()) / "tactiledata-rig-bank")
    parser.add_argument("--out", type=Path, default=Path("stories"))
    parser.add_argument("--pictures", type=Path, help="folder for a picture of each story")
    asked = parser.parse_args()
    for story in asked.stories:
        if story not in STORIES:
            parser.error(f"no story is called {story!r}; there are: {', '.join(STORIES)}")
    plan = WorldPlan(0, asked.quick, asked.mounts)
    bench = Bench.of(plan, asked.bank, not (asked.quick or asked.without_variants))
    maker = WorldMaker.of(plan, asked.bank)
    for story in asked.stories or STORIES:
        tell(story, bench, maker, asked.out, asked.pictures)


if __name__ == "__main__":
    main()
