"""Print where locators find that simulated recordings of a sealed proof depart from their simulation.

    python benchmarks/proof_located.py PROOF [PROOF ...] [--workers N] [--bank BANK] [--json FILE]
    python benchmarks/proof_located.py PROOF [PROOF ...] --errors

A PROOF is a folder that `tactiledata prove --out` made and answered; the plays of its plans are kept where that
command keeps them. The plain simulation is fitted to the readings of each case, and the locators tell certain findings
in what it leaves. *Where* is right if a covariate, a phase, an event or a cause of the zeros is told that
`locating_worlds.SHOWS_IN` has for the hidden effect, as physics says and before anything was run. Beside it stands the
share of all other effects of that table of which the same words would have been right: words that fit everything tell
nothing. Worlds that hide nothing are the control.

With ``--errors`` the worlds that hide nothing tell how contrasts scatter by errors of the simulation, beyond noise:
the numbers of `touch_residuals.OF_THE_GEL`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from locating_worlds import SHOWS_IN, told
from numpy.typing import NDArray
from proof_cases import ProofCase, of_cases, proof_cases, proof_parser
from timing import table

from tactiledata.contract.atomic import write_json_atomic
from tactiledata.diagnose.locate.contrasts import instruments_of, sizes_of
from tactiledata.diagnose.naming.error_sizes import with_estimated_errors
from tactiledata.diagnose.naming.joint_fit import JointFit, plain_fit
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.diagnose.unseen.touch_residuals import (
    OF_THE_GEL,
    case_noise,
    case_residuals,
    contrast_units,
    locate_touches,
    scatter_beyond_noise,
)
from tactiledata.diagnose.zeros.causes import zero_causes
from tactiledata.prove.cases.kinds import NULLS, VISIBLE
from tactiledata.prove.worlds.played_plan import START

Array = NDArray[np.float64]

ALIKE = {"fy": "fx", "ty": "tx"}
"""Components whose errors are taken to be the same: trajectories slide to all sides."""


def fitted(case: ProofCase) -> tuple[WhitenedTouches, JointFit]:
    """The trajectories of a case, and the plain fit to them, as naming makes it."""
    white = WhitenedTouches.of(case.touch_set, NamingOptions().errors)
    return with_estimated_errors(white, plain_fit(white, START))


def contrast_sizes(case: ProofCase) -> dict[str, tuple[Array, Array]]:
    """Sizes of all contrasts and their variances by noise, by what differs, in the units of errors of a simulation."""
    white, base = fitted(case)
    residuals, inflation = case_residuals(white, base), case_noise(white, base).inflation or 1.0
    units = contrast_units(white, base)
    found: dict[str, tuple[Array, Array]] = {}
    for one in sizes_of(project(residuals), instruments_of(residuals), OF_THE_GEL, inflation):
        found[one.what] = (one.size / units[one.what], one.variance / units[one.what] ** 2)
    return found


def print_errors(found: Sequence[Mapping[str, tuple[Array, Array]]]) -> None:
    """Print by how much contrasts of each kind scatter beyond noise in a world: in the median, in 90 %, at most.

    The last column is the largest contrast of a world in standard deviations, noise and the 90 % together.
    """
    rows = []
    for what in OF_THE_GEL:
        same = [name for name in OF_THE_GEL if ALIKE.get(name, name) == ALIKE.get(what, what)]
        worlds = []
        for one in found:
            if listed := [one[name] for name in same if name in one]:
                worlds.append(tuple(np.concatenate(column) for column in zip(*listed, strict=True)))
        if not worlds:
            continue
        errors = [scatter_beyond_noise(*world) for world in worlds]
        usual = float(np.quantile(errors, 0.9))
        largest = max(float((np.abs(s) / np.sqrt(v + usual**2)).max()) for s, v in worlds)
        rows.append((what, f"{np.median(errors):.2g}", f"{usual:.2g}", f"{max(errors):.2g}", f"{largest:.1f}"))
    table(("contrasts of", "median", "90 %", "most", "largest contrast"), rows)


def located(one: ProofCase) -> dict[str, Any]:
    """What the locators tell of a case, and whether it is right."""
    case, read = one.case, one.read
    found = locate_touches(*fitted(one))
    where = told(found)[1]
    causes = zero_causes(read.zeros, band=read.dead_band)
    where |= {f"zeros: {cause.effect}" for cause in causes if cause.matters}
    others = [shows_in for effect, shows_in in SHOWS_IN.items() if effect != case.hidden]
    return {
        "case": case.name,
        "kind": case.kind,
        "generator": case.configuration.split()[0],
        "hidden": case.hidden,
        "is_structured": found.is_structured,
        "told": sorted(where),
        "is_right": bool(where & SHOWS_IN.get(case.hidden, set())),
        "by_chance": float(np.mean([bool(where & shows_in) for shows_in in others])),
        "sentences": found.sentences(),
    }


def print_tables(found: Sequence[Mapping[str, Any]]) -> None:
    """Print a line a visible case, then how many are right in each generator, and the control."""
    visible = [one for one in found if one["kind"] == VISIBLE]
    rows = []
    for one in sorted(visible, key=lambda each: (each["generator"], each["hidden"])):
        right = ", ".join(sorted(set(one["told"]) & SHOWS_IN[one["hidden"]])) or "-"
        rows.append((one["generator"], one["hidden"], right, len(one["told"]), f"{one['by_chance']:.2f}"))
    table(("generator", "hidden", "right words", "words", "right of other effects"), rows)
    sums = []
    for generator in sorted({one["generator"] for one in found}):
        mine = [one for one in visible if one["generator"] == generator]
        nulls = [one for one in found if one["generator"] == generator and one["kind"] == NULLS]
        sums.append((
            generator,
            f"{sum(one['is_structured'] for one in mine)} of {len(mine)}",
            f"{sum(one['is_right'] for one in mine)} of {len(mine)}",
            f"{sum(one['by_chance'] for one in mine):.1f}",
            f"{sum(bool(one['told']) for one in nulls)} of {len(nulls)}",
        ))  # fmt: skip
    table(("generator", "structure", "where right", "by chance", "words in nulls"), sums)


def main() -> None:
    """Locate in every case that hides one effect of the table or nothing, and print the tables."""
    parser = proof_parser(__doc__)
    parser.add_argument("--errors", action="store_true", help="measure what errors of the simulation bring instead")
    given = parser.parse_args()
    nulls = proof_cases(given, (NULLS,))
    if given.errors:
        print_errors(list(of_cases(contrast_sizes, nulls, given.workers)))
        return
    visible = [one for one in proof_cases(given, (VISIBLE,)) if one.case.hidden in SHOWS_IN]
    found = []
    for one in of_cases(located, [*nulls, *visible], given.workers):
        found.append(one)
        print(f"{one['case']}: {' '.join(one['sentences'])}", flush=True)
    print_tables(found)
    if given.json:
        write_json_atomic(given.json, found)


if __name__ == "__main__":
    main()
