"""The plays of a first diagnosis, all made at finite strain and mostly estimated: processor time and errors.

    python benchmarks/estimated_plays.py [--quick] [--touches 36] [--plan N]

Touches are the first of the wedge plan. Both ways start without kept plays; the estimates are made between two halves
of the full plays, so that other load on the machine meets both. Errors are those of the estimated plays against the
full ones: root mean squares of differences in force, as a share of the largest force of the touch, and of the change
that a play shows.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from gel_failures import COARSE
from numpy.typing import NDArray
from timing import header

from tactiledata.calibrate.plays.estimated_plays import Estimates
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.diagnose.touches.grid_answer import TouchPlays
from tactiledata.diagnose.touches.play_grid import play_touches
from tactiledata.diagnose.touches.variant_plays import design_variants, variants_of
from tactiledata.effects import EFFECTS
from tactiledata.gel.engines.fem import Fidelity
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.structured_pad import structured_pad
from tactiledata.prove.worlds.recorder import WorldMaker
from tactiledata.prove.worlds.touches import to_play
from tactiledata.prove.worlds.wedges import WedgePlan
from tactiledata.sensors.digit import DIGIT

Array = NDArray[np.float64]
QUICK = 18
"""Touches with ``--quick``: enough that most are learned from a few."""


def played(
    plan: WedgePlan, mesh: PadMesh, touches: Sequence[MeasuredTouch], estimates: Estimates
) -> tuple[list[TouchPlays], float]:
    """Plays of touches without any kept ones, and the seconds of processor that they took."""
    fidelity: Fidelity = "finite-strain"
    with tempfile.TemporaryDirectory() as cache:
        os.environ["TACTILEDATA_CACHE"] = cache
        began = time.process_time()
        plays = play_touches(
            mesh,
            fidelity,
            touches,
            plan.bounds,
            variants=variants_of(EFFECTS),
            estimates=estimates,
        )
        return plays, time.process_time() - began


def errors(pairs: Sequence[tuple[TouchPlays, TouchPlays]], take: Callable[[TouchPlays], Array]) -> tuple[float, float]:
    """Error of an estimated force or change, over the touch's largest force and over itself; root mean squares.

    Parameters
    ----------
    pairs
        Full and estimated plays of each touch.
    take : callable
        Force, or change of force (..., n, 3), of plays.
    """
    off, size, shares = 0.0, 0.0, []
    for full, quick in pairs:
        largest = np.nanmax(np.linalg.norm(full.level[..., :3], axis=-1))
        difference, whole = take(quick) - take(full), take(full)
        off += float(np.nansum(difference**2))
        size += float(np.nansum(whole**2))
        shares.append(np.linalg.norm(difference, axis=-1).ravel() / largest)
    every = np.concatenate(shares)
    return float(np.sqrt(np.nanmean(every**2))), float(np.sqrt(off / size)) if size > 0 else float("nan")


def main() -> None:
    """Play both ways; print the ratio of processor time and a line for each kind of play."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help=f"{QUICK} touches on a coarse pad")
    parser.add_argument("--touches", type=int, default=36)
    parser.add_argument("--plan", type=int, default=0)
    options = parser.parse_args()
    plan = WedgePlan(options.plan)
    mesh = structured_pad("coarse", DIGIT.gel, COARSE) if options.quick else plan.mesh
    with tempfile.TemporaryDirectory() as bank:
        touches = to_play(WorldMaker.of(plan, Path(bank)).touches)[: QUICK if options.quick else options.touches]
    frames = sum(len(touch.seconds) for touch in touches)
    header(f"plays of {len(touches)} touches, {frames} frames, plan {options.plan}", ("numpy", "scipy", "numba"))
    half = len(touches) // 2
    full, first_half = played(plan, mesh, touches[:half], estimates="none")
    quick, of_quick = played(plan, mesh, touches, estimates="learned")
    rest, second_half = played(plan, mesh, touches[half:], estimates="none")
    pairs = list(zip([*full, *rest], quick, strict=True))
    seconds = {"full": first_half + second_half, "estimated": of_quick}
    print("| way | processor, ms a frame | ratio |\n|---|---|---|")
    for way, spent in seconds.items():
        print(f"| {way} | {1e3 * spent / frames:.0f} | {spent / seconds['full']:.2f} |")
    middle = pairs[0][0].plan.middle
    middle_ratio, middle_friction = middle
    takes: dict[str, Callable[[TouchPlays], Array]] = {
        "force at all nu and mu": lambda plays: plays.level[..., :3],
        "change by nu and mu": lambda plays: (plays.level - plays.level[middle_ratio, middle_friction])[..., :3],
        "slope over the offset, at all nu": lambda plays: plays.by_ratio[:, 0, :, :3] * plays.plan.offset,
        "slope over the offset, at all mu": lambda plays: plays.by_friction[:, 0, :, :3] * plays.plan.offset,
    }
    for name in EFFECTS:
        needed = design_variants(EFFECTS[name]())
        if needed:
            takes[f"change by {name}"] = lambda plays, needed=needed: np.stack(
                [plays.variants[variant][:, :3] for variant in needed if variant in plays.variants]
            )
    print("\n| what | error, % of the largest force | error, % of itself |\n|---|---|---|")
    for what, take in takes.items():
        of_force, of_itself = errors(pairs, take)
        print(f"| {what} | {100 * of_force:.2f} | {100 * of_itself:.1f} |")


if __name__ == "__main__":
    main()
