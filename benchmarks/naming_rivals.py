"""Naming missing physics: ours beside a BIC ladder, sparse regression and a Gaussian process, on the same cases.

    python benchmarks/naming_rivals.py [--quick] [--mounts M] [--bank FOLDER] [--nulls 5] [--only EFFECT ...]
                                       [--out FILE.jsonl]

The cases are those of benchmarks/naming_worlds.py: the rig's layer solver presses and hides effects in formulas of its
own. A name is right where what is hidden stands first among what a method says, and in the set where it is said at
all; on worlds that hide nothing every name is false. Seconds are of the processor, plays of the gel on disk; pysindy
has to be installed (`pip install -c constraints.txt -e '.[dev]'`).
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from naming_asked import Asked, asked_cases
from naming_worlds import Bench
from rival_methods import Case, bic_ladder, gaussian_process, ours, sparse_regression
from timing import header, table

from tactiledata.prove.worlds.plan import WorldPlan
from tactiledata.prove.worlds.played_plan import START

METHODS: dict[str, Callable[[Case], tuple[str, ...]]] = {
    "ours": ours,
    "BIC ladder": bic_ladder,
    "sparse regression (pysindy)": sparse_regression,
    "Gaussian process": gaussian_process,
}
HIDDEN = ("relaxation", "arm_compliance", "frame_rotation", "cross_talk", "lag", "stem_bending")


def run(bench: Bench, asked: Asked) -> list[dict[str, Any]]:
    """One case by all methods; each begins with the cases and shares nothing with the others."""
    truth = bench.gel(asked.seed)
    cases = bench.maker.cases(bench.maker.recorded(asked.seed, truth, asked.hidden, asked.more), bench.family)
    found = []
    for name, method in METHODS.items():
        began = time.process_time()
        said = method(Case(cases, START, bench.effects))
        seconds = time.process_time() - began
        found.append({"case": asked.label, "truth": list(asked.truth), "method": name, "said": list(said),
                      "seconds": seconds})  # fmt: skip
        print(f"{asked.label}: {name}: {', '.join(said) or 'nothing'}; {seconds:.1f} s", flush=True)
    return found


def show(found: list[dict[str, Any]]) -> None:
    """A row for each method."""
    rows = []
    for name in METHODS:
        own = [one for one in found if one["method"] == name]
        hidden, nulls = [one for one in own if one["truth"]], [one for one in own if not one["truth"]]
        first = sum(one["said"][:1] == one["truth"][:1] for one in hidden)
        among = sum(bool(set(one["said"]) & set(one["truth"])) for one in hidden)
        wrong = sum(bool(one["said"]) and not set(one["said"]) & set(one["truth"]) for one in hidden)
        size = np.mean([len(one["said"]) for one in hidden if one["said"]] or [0])
        rows.append((
            name, f"{first} of {len(hidden)}", f"{among} of {len(hidden)} (mean {size:.1f} names)",
            f"{wrong} of {len(hidden)}", f"{sum(bool(one['said']) for one in nulls)} of {len(nulls)}",
            f"{np.median([one['seconds'] for one in own]):.1f}",
        ))  # fmt: skip
    columns = ("method", "named first", "among its names", "only wrong names", "names on nulls", "s a case")
    table(columns, rows)


def main() -> None:
    """Run what is not in the file yet, then show the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="ten touches on a coarse linear pad; shows that it works")
    parser.add_argument("--with-variants", action="store_true", help="effects that need other gels played, too")
    parser.add_argument("--nulls", type=int, default=5)
    parser.add_argument("--mounts", type=int, default=5, help="of each of the five indenters, a touch each")
    parser.add_argument("--only", nargs="*", default=HIDDEN, help="of the rig's effects")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--bank", type=Path, default=Path(tempfile.gettempdir()) / "tactiledata-rig-bank")
    options = parser.parse_args()
    hidden = ("frame_rotation",) if options.quick else options.only
    cases = asked_cases(("nulls",), 1 if options.quick else options.nulls, "none")
    cases += [one for one in asked_cases(("effects",), 1, "medium") if one.effects[0] in hidden]
    lines = options.out.read_text().splitlines() if options.out and options.out.is_file() else []
    found = [json.loads(line) for line in lines]
    todo = [one for one in cases if one.label not in {each["case"] for each in found}]
    import pysindy  # noqa: F401 (takes seconds, which are no case's)

    header("naming missing physics", ("numpy", "scipy", "scikit-learn", "pysindy"))
    if todo:
        bench = Bench.of(WorldPlan(0, options.quick, options.mounts), options.bank, options.with_variants)
        for asked in todo:
            said = run(bench, asked)
            found += said
            if options.out:
                with options.out.open("a") as file:
                    file.writelines(json.dumps(one) + "\n" for one in said)
    show(found)


if __name__ == "__main__":
    main()
