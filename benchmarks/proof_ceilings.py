"""Print the evidence that the best formula could bring in visible cases of a sealed proof, beside what a claim needs.

    python benchmarks/proof_ceilings.py PROOF [PROOF ...] [--bank BANK] [--json FILE]

A PROOF is a folder that `tactiledata prove --out` made and answered; the solutions of its generators and the plays of
its plans are kept where that command keeps them. For each case with one effect of the catalogue the generator tells
what the effect changes, without noise. That change is taken from the readings that were diagnosed, and the plain
simulation is fitted with it and without, in the metric of a diagnosis: noise, errors of the simulation of the sizes
that the data want, and dispersion. The difference is the ceiling: the evidence that a formula would have which is right
to the last digit, and whose numbers nobody had to fit. Sizes of errors are those that the readings want, or those that
suit the readings without the change, whichever brings more, as in a diagnosis.

Where the ceiling is below what a claim of the effect needs, no formula could have been named: errors of a simulation as
large as these data allow could look the same. Where it is above, a formula that is near enough would have the evidence.
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from timing import header, table

from tactiledata.arrays import Array
from tactiledata.contract.atomic import write_json_atomic
from tactiledata.diagnose.naming.error_sizes import (
    estimated_sizes,
    size_penalty,
    typical_size,
    with_errors_of,
    with_estimated_errors,
    with_estimated_sizes,
)
from tactiledata.diagnose.naming.held_out import held_out
from tactiledata.diagnose.naming.joint_fit import JointFit, joint_fit, plain_fit
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.own_error_sizes import with_estimated_own_sizes
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.gel.elasticity.compliance import cache_folder
from tactiledata.prove.cases.configuration import Configuration, played_plan
from tactiledata.prove.cases.drawn_world import DrawnWorld
from tactiledata.prove.cases.kinds import CONCEALED, VISIBLE
from tactiledata.prove.cases.oracle import with_wrenches
from tactiledata.prove.score.outcome import IN_SET, NAMED
from tactiledata.prove.score.scored_case import ScoredCase
from tactiledata.prove.seal.folder import ProofFolder, read_readings
from tactiledata.prove.seal.verify import scored_cases
from tactiledata.prove.worlds.logs import LogReadings
from tactiledata.prove.worlds.played_plan import START

OWN = {
    "lag": "sensor and clock", "clock_skew": "sensor and clock", "sensor_drift": "sensor and clock",
    "gain_crosstalk": "sensor and clock", "frame_rotation": "sensor and clock", "quantisation": "sensor and clock",
    "clipping": "sensor and clock", "inertia": "sensor and clock", "cable_drag": "sensor and clock",
    "tool_weight": "sensor and clock",
    "rate_friction": "friction", "static_friction": "friction", "area_friction": "friction", "partial_slip": "friction",
}  # fmt: skip
"""Part of the rig in which each effect of the catalogue acts, by the effect's name, as the second table groups them; an
effect that is not listed acts in the gel, the indenter or the arm (``ELSEWHERE``)."""
ELSEWHERE = "gel, indenter, arm"


def ceiling(touch_set: TouchSet, change: Array, effect: str) -> dict[str, float]:
    """Return the evidence of an exact formula and what a claim needs beside the errors that it leaves.

    Parameters
    ----------
    touch_set : TouchSet
        Trajectories with what is hidden, as a diagnosis reads them.
    change : (N, 6), N and N m
        What is hidden changes, without noise.
    effect : str
        The effect of the catalogue that is to be claimed.
    """
    measured = np.concatenate([case.measured for case in touch_set.touches])
    without = with_wrenches(touch_set, measured - change)
    options = NamingOptions()
    white = WhitenedTouches.of(touch_set, options.errors)
    white, base = with_estimated_errors(white, plain_fit(white, START))
    best, white_of_best, bare, penalty = _explained(white, base, without), white, base, 0.0
    evidence = 0.5 * (base.cost - best.cost)
    # with the sizes that suit the readings without the change
    smaller = with_estimated_own_sizes(with_estimated_sizes(_other(white, without), best), best)
    smaller = _other(smaller, touch_set)
    base_there = joint_fit(smaller, with_errors_of(base.model, white, smaller))
    best_there, penalty_there = _explained(smaller, base_there, without), size_penalty(white, base, smaller)
    evidence_there = 0.5 * (base_there.cost - best_there.cost) - penalty_there
    if evidence_there > evidence:
        best, white_of_best, bare, penalty = best_there, smaller, base_there, penalty_there
    cleaned = _other(white_of_best, without)
    left = held_out(cleaned, best, options.seed).by_trajectory
    dispersion = max(1.0, float(left.sum() / cleaned.expected.sum()))
    thresholds = options.thresholds.for_data(len(white.starts), white_of_best.precision)
    size = typical_size(estimated_sizes(cleaned, best))
    return {
        "evidence": round(float(0.5 * (bare.cost - best.cost) - penalty) / dispersion, 1),
        "need": round(thresholds.with_errors(size).needed((effect,)), 1),
        "error_size": round(size, 2),
        "error_size_with": round(typical_size(estimated_sizes(white, base)), 2),
        "dispersion": round(dispersion, 2),
    }


def _other(white: WhitenedTouches, touch_set: TouchSet) -> WhitenedTouches:
    """Trajectories with other readings, in the same units."""
    return WhitenedTouches(touch_set, white.errors, white.trust, white.own, white.simulated)


def _explained(white: WhitenedTouches, near: JointFit, without: TouchSet) -> JointFit:
    """Plain simulation fitted to readings without the change, from where the fit with it ended."""
    return joint_fit(_other(white, without), near.model)


def compared(folder: ProofFolder, case: ScoredCase, bank: Path) -> dict[str, Any]:
    """Return the ceiling of a case beside what was answered."""
    label = case.label
    configuration = Configuration(**label["configuration"])
    world = DrawnWorld(played_plan(configuration.plan, bank, True), configuration, label["seed"])
    maker = world.played.maker
    felt = np.concatenate(maker.observed(world.readings(label["hidden"], is_exact=True)).wrenches)
    read = maker.observed([LogReadings(*one) for one in read_readings(folder.case(case.name))])
    (own,) = label["truth"]
    found = ceiling(maker.cases(read, world.played.family), felt - world.clean, own)
    refitted = [one["evidence"] for one in case.answer["candidates"] if one["effects"] == [own]]
    return {
        "case": case.name,
        "kind": case.kind,
        "generator": label["configuration"]["generator"],
        "mismatch": label["configuration"]["mismatch"],
        "hidden": case.hidden,
        "effect": own,
        "signal": case.signal,
        **found,
        "own_evidence": round(refitted[0], 1) if refitted else None,
        "is_named": case.outcome in (NAMED, IN_SET),
    }


def print_tables(found: Sequence[Mapping[str, Any]]) -> None:
    """Print a line a case, the highest ceiling over its need first, then how many are named on either side of it."""
    rows = []
    for one in sorted(found, key=lambda each: (-each["evidence"] / each["need"], each["case"])):
        refitted = "-" if one["own_evidence"] is None else f"{one['own_evidence']:.0f}"
        rows.append((
            one["case"][:8], f"{one['generator']} {one['mismatch']:g}", one["hidden"], f"{one['signal']:.0f}",
            f"{0.5 * one['signal'] ** 2:.0f}", f"{one['evidence']:.0f}", f"{one['need']:.0f}", refitted,
            f"{one['error_size_with']:.1f} to {one['error_size']:.1f}", "named" if one["is_named"] else "-",
        ))  # fmt: skip
    names = ("case", "generator", "hidden", "signal", "by noise", "ceiling", "need", "own", "errors", "answer")
    table(names, rows)
    sums = []
    for where in sorted({OWN.get(one["effect"], ELSEWHERE) for one in found}):
        mine = [one for one in found if OWN.get(one["effect"], ELSEWHERE) == where]
        over = [one for one in mine if one["evidence"] >= one["need"]]
        under = [one for one in mine if one["evidence"] < one["need"]]
        share = statistics.median(one["evidence"] / (0.5 * one["signal"] ** 2) for one in mine)
        sums.append((
            where, f"{sum(one['is_named'] for one in over)} of {len(over)}",
            f"{sum(one['is_named'] for one in under)} of {len(under)}", f"{share:.2f}",
        ))  # fmt: skip
    table(("effects of", "named, ceiling above the need", "named, below it", "median ceiling by noise"), sums)


def main() -> None:
    """Compare all visible and concealed cases with one effect, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("proofs", type=Path, nargs="+")
    parser.add_argument("--bank", type=Path, default=cache_folder() / "generators")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    header("evidence of an exact formula in sealed worlds (simulated recordings)", ("numpy", "scipy", "numba"))
    found = []
    for path in options.proofs:
        folder = ProofFolder(path.absolute())
        for case in scored_cases(folder):
            if case.kind in (VISIBLE, CONCEALED):
                found.append(compared(folder, case, options.bank))
    print_tables(found)
    if options.json:
        write_json_atomic(options.json, found)


if __name__ == "__main__":
    main()
