"""Print the evidence that the best formula could bring in visible cases of a sealed proof, beside what a claim needs.

    python benchmarks/proof_ceilings.py PROOF [PROOF ...] [--workers N] [--bank BANK] [--json FILE]

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

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from proof_cases import ProofCase, of_cases, proof_cases, proof_parser
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
from tactiledata.effects import EFFECTS
from tactiledata.effects.base import SLOT_TITLES, SLOTS
from tactiledata.prove.cases.kinds import CONCEALED, VISIBLE
from tactiledata.prove.cases.oracle import with_wrenches
from tactiledata.prove.worlds.played_plan import START


@dataclass(frozen=True)
class _Setting:
    """One choice of sizes of the simulation's errors, and the plain simulation fitted with it.

    Parameters
    ----------
    white : WhitenedTouches
        Trajectories with what is hidden, in units of noise and of these errors.
    bare, exact : JointFit
        Plain fit to the readings, and to them without the change by what is hidden.
    penalty : float
        What the sizes cost beside those that the readings want.
    """

    white: WhitenedTouches
    bare: JointFit
    exact: JointFit
    penalty: float = 0.0

    @property
    def evidence(self) -> float:
        """Evidence of an exact formula, before the dispersion."""
        return 0.5 * (self.bare.cost - self.exact.cost) - self.penalty


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
    plain = WhitenedTouches.of(touch_set, options.errors)
    white, base = with_estimated_errors(plain, plain_fit(plain, START))
    wanted = _Setting(white, base, joint_fit(replace(white, touch_set=without), base.model))
    # sizes that suit the readings without the change
    cleaned = replace(white, touch_set=without)
    cleaned = with_estimated_own_sizes(with_estimated_sizes(cleaned, wanted.exact), wanted.exact)
    smaller = replace(cleaned, touch_set=touch_set)
    bare = joint_fit(smaller, with_errors_of(base.model, white, smaller))
    suited = _Setting(smaller, bare, joint_fit(cleaned, bare.model), size_penalty(white, base, smaller))
    best = max(wanted, suited, key=lambda setting: setting.evidence)
    # the dispersion, and what a claim needs beside the errors that are left
    cleaned = replace(best.white, touch_set=without)
    left = held_out(cleaned, best.exact, options.seed).by_trajectory
    dispersion = max(1.0, float(left.sum() / cleaned.expected.sum()))
    thresholds = options.thresholds.for_data(len(white.starts), best.white.precision)
    size = typical_size(estimated_sizes(cleaned, best.exact))
    return {
        "evidence": round(best.evidence / dispersion, 1),
        "need": round(thresholds.with_errors(size).needed((effect,)), 1),
        "error_size": round(size, 2),
        "error_size_with": round(typical_size(estimated_sizes(white, base)), 2),
        "dispersion": round(dispersion, 2),
    }


def compared(hidden: ProofCase) -> dict[str, Any]:
    """Return the ceiling of a case beside what was answered."""
    found = ceiling(hidden.touch_set, hidden.change, hidden.effect)
    candidates = hidden.case.answer["candidates"]
    refitted = [one["evidence"] for one in candidates if one["effects"] == [hidden.effect]]
    return {**hidden.document, **found, "own_evidence": round(refitted[0], 1) if refitted else None}


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
    for slot in SLOTS:
        mine = [one for one in found if EFFECTS[one["effect"]].slot == slot]
        if not mine:
            continue
        over = [one for one in mine if one["evidence"] >= one["need"]]
        under = [one for one in mine if one["evidence"] < one["need"]]
        share = statistics.median(one["evidence"] / (0.5 * one["signal"] ** 2) for one in mine)
        sums.append((
            SLOT_TITLES[slot], f"{sum(one['is_named'] for one in over)} of {len(over)}",
            f"{sum(one['is_named'] for one in under)} of {len(under)}", f"{share:.2f}",
        ))  # fmt: skip
    table(("effects of", "named, ceiling above the need", "named, below it", "median ceiling by noise"), sums)


def main() -> None:
    """Compare all visible and concealed cases with one effect, and print the tables."""
    given = proof_parser(__doc__).parse_args()
    header("evidence of an exact formula in sealed worlds (simulated recordings)", ("numpy", "scipy", "numba"))
    found = list(of_cases(compared, proof_cases(given, (VISIBLE, CONCEALED)), given.workers))
    print_tables(found)
    if given.json:
        write_json_atomic(given.json, found)


if __name__ == "__main__":
    main()
