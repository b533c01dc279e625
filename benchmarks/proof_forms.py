"""Print how well effects of the catalogue can imitate what worlds of a sealed proof hide, beyond a plain refit.

    python benchmarks/proof_forms.py PROOF [PROOF ...] [--workers N] [--bank BANK] [--json FILE]

A PROOF is a folder that `tactiledata prove --out` made and answered; the solutions of its generators and the plays of
its plans are kept where that command keeps them. For each visible case the generator tells its wrenches without noise,
with what is hidden and without. The change between the two, beyond what E, nu, mu, contact offsets and errors of the
simulation take up, is compared with the signature of every effect of the catalogue, to first order and at the shapes
that a screen tries. The square of the cosine is the share of the signal's square that an effect can take.

Where the cosine with an effect's own entry of the catalogue is small, a fit of that entry has little to find: the
formula that hides it and the one that looks for it differ in what a calibration leaves. To first order alone an effect
whose shape is fitted afterwards (the time of a jump, say) seems less alike than it is.
"""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

from proof_cases import ProofCase, of_cases, proof_cases, proof_parser
from timing import header, table

from tactiledata.contract.atomic import write_json_atomic
from tactiledata.prove.cases.kinds import VISIBLE
from tactiledata.prove.cases.oracle import imitations

ENDS = (0.0, 0.3, 0.6, 1.0)
"""Ends of the ranges of cosines in which named effects are counted."""


def compared(hidden: ProofCase) -> dict[str, Any]:
    """Return the cosines of what a case hides with every effect of the catalogue, and what was answered."""
    world = hidden.world
    cosines = imitations(world.plain, world.touch_set, hidden.change, world.played.effects)
    return {
        **hidden.document,
        "absorbed": hidden.case.label["sight"]["absorbed"],
        "own": round(cosines.get(hidden.effect, 0.0), 3),
        "cosines": {name: round(cosine, 3) for name, cosine in sorted(cosines.items(), key=lambda one: -one[1])},
    }


def print_tables(found: Sequence[Mapping[str, Any]]) -> None:
    """Print a line a case, the most alike first, then how many are named by ranges of the cosine."""
    rows = []
    for one in sorted(found, key=lambda each: (-each["own"], each["case"])):
        name, cosine = next(((n, c) for n, c in one["cosines"].items() if n != one["effect"]), ("-", 0.0))
        rows.append((
            one["case"][:8], f"{one['generator']} {one['mismatch']:g}", one["hidden"], f"{one['signal']:.0f}",
            f"{one['absorbed']:.2f}", f"{one['own']:.2f}", f"{name} {cosine:.2f}", "named" if one["is_named"] else "-",
        ))  # fmt: skip
    table(("case", "generator", "hidden", "signal", "absorbed", "own cosine", "best other", "answer"), rows)
    sums = []
    for low, high in pairwise(ENDS):
        # a cosine of exactly 1 belongs to the last range
        mine = [one for one in found if low <= one["own"] < high or one["own"] == high == ENDS[-1]]
        signals = [one["signal"] for one in mine]
        sums.append((
            f"{low:g} to {high:g}", f"{sum(one['is_named'] for one in mine)} of {len(mine)}",
            f"{statistics.median(signals):.0f}" if signals else "-",
        ))  # fmt: skip
    table(("own cosine", "named", "median signal"), sums)


def main() -> None:
    """Compare all visible cases, and print the tables."""
    given = proof_parser(__doc__).parse_args()
    header("what worlds hide beside the catalogue's forms (simulated recordings)", ("numpy", "scipy", "numba"))
    found = list(of_cases(compared, proof_cases(given, (VISIBLE,)), given.workers))
    print_tables(found)
    if given.json:
        write_json_atomic(given.json, found)


if __name__ == "__main__":
    main()
