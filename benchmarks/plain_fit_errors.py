"""How far E, nu and mu of the plain simulation are off in worlds where nothing is missing, and what pulls them.

    python benchmarks/plain_fit_errors.py [--generator layer|analytic] [--mismatch SIZE ...] [--solver SEED] [--plan N]
                                          [--seeds N ...] [--slides] [--bank FOLDER]

The worlds are the nulls of `mismatch_worlds`. Three fits each: errors in proportion to the readings; in proportion to
the simulated wrenches; and with the sizes of all errors estimated, as `diagnose` does it. With `--slides`, the largest
ratio of shear to load of each touch follows, as recorded without noise and as the gel has it with the true numbers.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from naming_worlds import Bench

from tactiledata.diagnose.naming.error_sizes import with_estimated_errors, with_simulated_by
from tactiledata.diagnose.naming.joint_fit import JointFit, plain_fit
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.prove.worlds.generators import make_generator
from tactiledata.prove.worlds.played_plan import START
from tactiledata.prove.worlds.solver_errors import OtherSolver
from tactiledata.prove.worlds.wedges import WedgePlan

LEAST = 0.5
"""N: smaller loads say nothing of a ratio."""


def fits(cases: TouchSet) -> dict[str, JointFit]:
    """The three fits by their names."""
    white = WhitenedTouches.of(cases)
    of_readings = plain_fit(white, START)
    white = with_simulated_by(white, of_readings)
    of_simulated = plain_fit(white, of_readings.model.material)
    return {
        "errors as shares of readings": of_readings,
        "errors as shares of simulated wrenches": of_simulated,
        "sizes of errors estimated": with_estimated_errors(white, of_simulated)[1],
    }


def slides(cases: TouchSet, exact: np.ndarray, truth: GelMaterial) -> list[str]:
    """A line for each touch that slides or shears: its indenter, largest ratio as recorded and in the gel."""
    played = cases.play(truth, [], np.zeros(len(cases.touches)))
    ends = np.cumsum(cases.counts)[:-1]
    lines = []
    for case, felt, gel in zip(cases.touches, np.split(exact, ends), np.split(played, ends), strict=True):
        held = (felt[:, 2] > LEAST) & (gel[:, 2] > LEAST)
        if held.any():
            ratios = [np.hypot(*one[held, :2].T) / one[held, 2] for one in (felt, gel)]
            at = int(ratios[0].argmax())
            lines.append(
                f"{case.touch.indenter_name:8s} load {felt[held, 2][at]:5.2f} N  recorded {ratios[0][at]:.3f}"
                f"  gel {ratios[1][at]:.3f}"
            )
    return lines


def main() -> None:
    """Print a line for each world and fit."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--generator", choices=("layer", "analytic"), default="layer")
    parser.add_argument("--mismatch", type=float, nargs="+", default=[1.0])
    parser.add_argument("--solver", type=int, default=0, help="seed of the solver's errors")
    parser.add_argument("--plan", type=int, default=0)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1000])
    parser.add_argument("--slides", action="store_true")
    parser.add_argument("--bank", type=Path, default=Path(tempfile.gettempdir()) / "tactiledata-rig-bank")
    options = parser.parse_args()
    bench = Bench.of(WedgePlan(options.plan), options.bank, False, ())
    solve = make_generator(options.generator, bench.maker.bank)
    for mismatch in options.mismatch:
        world = replace(bench, maker=replace(bench.maker, solve=OtherSolver(solve, mismatch, options.solver)))
        for seed in options.seeds:
            truth = world.gel(seed)
            cases = world.maker.cases(world.maker.recorded(seed, truth, []), world.family)
            for name, fit in fits(cases).items():
                found = fit.model.material
                print(
                    f"mismatch {mismatch:g}, seed {seed}, {name}: E {_off(found.youngs_modulus, truth.youngs_modulus)},"
                    f" nu {found.poisson_ratio - truth.poisson_ratio:+.4f}, mu {_off(found.friction, truth.friction)},"
                    f" cost {fit.cost:.0f}"
                )
            if options.slides:
                exact = world.maker.recorded(seed, truth, [], is_exact=True)
                print("\n".join(slides(cases, np.concatenate(exact.wrenches), truth)))


def _off(found: float, truth: float) -> str:
    """Return by how many per cent a number differs from the truth, in words."""
    return f"{100 * (found / truth - 1):+.1f} %"


if __name__ == "__main__":
    main()
