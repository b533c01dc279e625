"""The touches of a plan solved by finite elements, and kept, so that worlds of that generator are recorded in seconds.

    python benchmarks/element_plan.py [--plan 3] [--count 2] [--seed 0] [--only NUMBER ...] [--bank FOLDER]

Solved is what null worlds of `mismatch_worlds.py --generator element --cases nulls --count K` ask for: each touch at
three depth offsets. Printed are processor seconds, steps, and steps without balance of each touch.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from naming_asked import asked_cases

from tactiledata.prove.element_world.bank import ElementBank, ElementContact
from tactiledata.prove.worlds.logs import play_logs, unfelt
from tactiledata.prove.worlds.wedges import WedgePlan
from tactiledata.rig.contact.contact import TouchSetup
from tactiledata.rig.scenario.scenario import load_scenario


@dataclass(frozen=True)
class Timed:
    """A bank that tells how long each touch took.

    Parameters
    ----------
    bank : ElementBank
    only : set of int
        Places of the touches in the plan that are solved; all where it is empty.
    names : list of str
        Of the plan's touches, in order.
    """

    bank: ElementBank
    only: frozenset[int]
    names: tuple[str, ...]

    def __call__(self, gel: Any, setup: TouchSetup, path: Any = None, deviation: Any = None) -> ElementContact:
        """The contact of a touch; without forces where it is not asked for."""
        number = self.names.index(setup.touch.name)
        if self.only and number not in self.only:
            return unfelt(gel, setup, path, deviation)
        known, began = set(self.bank.kept), time.process_time()
        contact = self.bank.contact(gel, setup, path, deviation)
        new = [one for key, one in self.bank.kept.items() if key not in known]
        told = f"{number} {setup.touch.name}: {time.process_time() - began:.1f} s of processor"
        told += f", solutions {len(new)}, steps {sum(one.steps for one in new)}"
        told += f", without balance {sum(one.unsettled for one in new)}, {contact.wrench[:, 2].max():.2f} N"
        print(told + f", offset {1e6 * setup.offset[2]:.0f} µm", flush=True)
        return contact


def main() -> None:
    """Solve what is not kept yet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plan", type=int, default=3)
    parser.add_argument("--count", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", type=int, nargs="*", default=[])
    parser.add_argument("--bank", type=Path, default=Path(tempfile.gettempdir()) / "tactiledata-element-bank")
    options = parser.parse_args()
    plan = WedgePlan(options.plan)
    names = tuple(touch["name"] for touch in plan.touches)
    solve = Timed(ElementBank(options.bank), frozenset(options.only), names)
    for case in asked_cases(["nulls"], options.count, "medium"):
        scenario = load_scenario(plan.scenario(case.seed + options.seed, plan.truth, []))
        plays = [play for log in play_logs(scenario, solve) for play in log.played.plays]
        peaks = np.array([play.contact.wrench[:, 2].max() for play in plays])
        print(f"seed {case.seed + options.seed}: {len(plays)} touches, up to {peaks.max():.1f} N", flush=True)


if __name__ == "__main__":
    main()
