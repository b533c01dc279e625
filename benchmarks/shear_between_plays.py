"""How far shear between plays is off what the gel engine plays itself: interpolated alone, and with springs beside it.

    python benchmarks/shear_between_plays.py [--plan wedge-13] [--touches 36] [--quick]

Touches are the first of a plan. Each is played once more by the gel engine, with another friction, at another depth, or
along the way that an indenter takes on a yielding arm or stem; E is 0.9 MPa, nu and mu (0.6) are those of the middle
play. Errors and changes are root mean squares of the shear over the frames and touches. With `--quick` six touches
are played on a coarse pad of small strain: a minute in all, and no gel.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from gel_failures import COARSE
from numpy.typing import NDArray
from timing import header

from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.diagnose.touches.grid_answer import TouchPlays
from tactiledata.diagnose.touches.play_grid import play_touches
from tactiledata.diagnose.touches.played_response import PlayedResponse
from tactiledata.effects.touch.touch import Touch
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.compliance import cache_folder
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import Fidelity
from tactiledata.gel.make_engine import make_engine
from tactiledata.gel.mesh.structured_pad import structured_pad
from tactiledata.prove.worlds.plan_names import named_plan
from tactiledata.prove.worlds.recorder import WorldMaker
from tactiledata.prove.worlds.touches import to_play

Array = NDArray[np.float64]
MODULUS, FRICTION = 0.9e6, 0.6
FRICTIONS = (0.08, 0.25, 0.5, 0.7, 1.1)
DEPTH = 1e-4
"""m."""
ARM, STEM = 2e-5, 6e-5
"""m/N: of an arm along the normal, and of a stem along the gel."""


@dataclass(frozen=True)
class Asked:
    """What a touch of n frames is asked: friction, how much deeper, m, and how much further along the gel, m."""

    what: str
    friction: float
    offset: Array
    shift: Array


def questions(touch: Touch, plays: TouchPlays) -> Iterator[Asked]:
    """All that a touch is asked."""
    count = len(touch)
    deeper, further = np.zeros(count), np.zeros((count, 2))
    for friction in FRICTIONS:
        yield Asked(f"friction {friction:g} in place of {FRICTION:g}", friction, deeper, further)
    for side in (-1.0, 1.0):
        yield Asked(
            f"{1e3 * DEPTH:g} mm {'deeper' if side > 0 else 'less deep'}", FRICTION, deeper + side * DEPTH, further
        )
    force = np.nan_to_num(MODULUS * answer(touch, plays, Asked("", FRICTION, deeper, further))[:, :3])
    yield Asked(f"on an arm of {1e6 * ARM:g} um/N", FRICTION, -ARM * force[:, 2], further)
    yield Asked(f"on a stem of {1e6 * STEM:g} um/N", FRICTION, deeper, STEM * force[:, :2])


def answer(touch: Touch, plays: TouchPlays, asked: Asked) -> Array:
    """Wrench (n, 6) over Young's modulus, as a diagnosis is told it."""
    gel = GelMaterial(1.0, plays.plan.ratios[1], FRICTION)
    factor = np.full(len(touch), asked.friction / FRICTION)
    return PlayedResponse(touch, plays, gel).respond(asked.offset, asked.shift, factor).wrench


def moved(touch: GelTouch, asked: Asked) -> GelTouch:
    """The touch that the engine plays."""
    poses = touch.poses.copy()
    poses[:, :2, 3] += asked.shift
    poses[:, 2, 3] -= asked.offset
    return GelTouch(touch.indenter, poses)


def square(shear: Array, known: NDArray[np.bool_]) -> float:
    """Sum of the squares of shear (n, 2) over Young's modulus, N^2."""
    return float(np.sum((MODULUS * shear[known]) ** 2))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plan", default="wedge-13")
    parser.add_argument("--touches", type=int, default=36)
    parser.add_argument("--quick", action="store_true", help="six touches on a coarse pad of small strain")
    given = parser.parse_args()
    plan = named_plan(given.plan)
    mesh = structured_pad("coarse", plan.geometry, COARSE) if given.quick else plan.mesh
    fidelity: Fidelity = "linear" if given.quick else "finite-strain"
    told = WorldMaker.of(plan, cache_folder() / "generators").touches[: 6 if given.quick else given.touches]
    measured: list[MeasuredTouch] = to_play(told)
    all_plays = play_touches(mesh, fidelity, measured, plan.bounds)
    header(f"shear between plays: {len(told)} touches of {given.plan}", ("numpy", "scipy"))
    asked_of = [list(questions(touch, plays)) for touch, plays in zip(told, all_plays, strict=True)]
    engine = make_engine(mesh, all_plays[0].plan.ratios[1], fidelity)
    print(
        "| asked | change of the shear, N | error, interpolated alone, N | error, with springs, N |\n|---|---|---|---|"
    )
    for place, first in enumerate(asked_of[0]):
        gel = GelMaterial(1.0, all_plays[0].plan.ratios[1], first.friction)
        sums, frames = np.zeros(3), 0
        asked = [each[place] for each in asked_of]
        played = [moved(one.touch, each) for one, each in zip(measured, asked, strict=True)]
        for number, history in engine.play(played, gel, "none"):
            touch, plays, each = told[number], all_plays[number], asked[number]
            true = history.wrench[:, :2]
            known = np.isfinite(true).all(axis=1) & plays.known
            usual = plays.level[1, 1, :, :2]
            alone = plays.at(gel.poisson_ratio, each.friction, each.offset, each.shift)[:, :2]
            with_springs = answer(touch, plays, each)[:, :2]
            sums += [square(one - true, known) for one in (usual, alone, with_springs)]
            frames += int(known.sum())
        change, alone_off, off = np.sqrt(sums / frames)
        print(f"| {first.what} | {change:.3f} | {alone_off:.3f} | {off:.3f} |", flush=True)


if __name__ == "__main__":
    main()
