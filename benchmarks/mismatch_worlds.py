"""Missing physics named where the simulation errs: worlds of several generators whose contact differs from the gel's.

    python benchmarks/mismatch_worlds.py [--generator layer|analytic|element] [--mismatch SIZE] [--solver SEED]
                                         [--noise FACTOR] [--plan N] [--cases nulls ...] [--seed N] [--count K]
                                         [--strength medium] [--estimated] [--out FILE.jsonl] [--bank FOLDER]

The simulation is our gel at finite strain. Generators are the rig's layer solver, the rig's closed forms and finite
elements of scikit-fem (`element_world`), each with errors of a solver that are drawn for each indenter
(`other_solvers`): at a mismatch of 1 some per cent, at 2 twice that. Touches are those of `wedge_plan`. What was played
and solved is kept, as in `naming_worlds`; `element_plan` solves what nulls by finite elements need. With `--estimated`
the answer is the first one, before the gels on which it could rest are played in full.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from naming_asked import DRAWN, KINDS, Asked, asked_cases
from naming_summary import summary
from naming_worlds import Bench, keep_and_tell

from tactiledata.effects import EFFECTS
from tactiledata.prove.worlds.generators import GENERATORS, SOLVED_ANEW, make_generator
from tactiledata.prove.worlds.solver_errors import OtherSolver
from tactiledata.prove.worlds.wedges import WedgePlan


def chosen(kinds: Sequence[str], count: int, strength: str, seed: int, only: Sequence[str]) -> list[Asked]:
    """Cases with other seeds than those of `naming_worlds`, without what takes hours."""
    cases = [replace(case, seed=case.seed + seed) for case in asked_cases(kinds, count, strength)]
    cases = [case for case in cases if not set(case.effects) & set(SOLVED_ANEW)]
    return [case for case in cases if not only or set(case.effects) & set(only)]


def main() -> None:
    """Run what is not in the file yet; print a line a case, then the summary."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--generator", choices=tuple(GENERATORS), default="layer")
    parser.add_argument("--mismatch", type=float, default=0.0)
    parser.add_argument("--solver", type=int, default=0, help="seed of the solver's errors")
    parser.add_argument("--noise", type=float, default=1.0)
    parser.add_argument("--plan", type=int, default=0)
    parser.add_argument("--cases", nargs="+", choices=KINDS, default=["nulls"])
    parser.add_argument("--count", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0, help="added to the seeds of the cases")
    parser.add_argument("--strength", choices=("weak", "medium", "strong", DRAWN), default="medium")
    parser.add_argument("--only", nargs="*", default=[], help="of the rig's effects")
    parser.add_argument("--no-pairs", action="store_true")
    parser.add_argument("--without-variants", action="store_true", help="leave out effects that need other gels played")
    parser.add_argument("--estimated", action="store_true", help="answer from estimated plays alone")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--bank", type=Path, default=Path(tempfile.gettempdir()) / "tactiledata-rig-bank")
    options = parser.parse_args()
    varied = () if options.without_variants else tuple(EFFECTS)
    bench = Bench.of(WedgePlan(options.plan), options.bank, not options.without_variants, varied)
    solve = make_generator(options.generator, bench.maker.bank)
    maker = replace(bench.maker, solve=OtherSolver(solve, options.mismatch, options.solver), noise=options.noise)
    bench = replace(bench, maker=maker, pairs=not options.no_pairs, in_full=not options.estimated)
    found = []
    for case in chosen(options.cases, options.count, options.strength, options.seed, options.only):
        kinds = ("generator", "mismatch", "solver", "noise", "plan")
        result = {**{kind: getattr(options, kind) for kind in kinds}, **bench.run(case)}
        found.append(result)
        keep_and_tell(case, result, options.out)
    print(summary(found))


if __name__ == "__main__":
    main()
