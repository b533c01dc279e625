"""Benchmarks one after the other: those of speed are `make bench`, those of accuracy `make accuracy`.

    python benchmarks/run_all.py [--what speed|accuracy] [--only NAME ...] [--out bench-out] [--quick]

Each also runs alone. What they print is shown, and kept in a file for each part in the folder of ``--out``, with the
plots; a table at the end has the minutes of each part and the targets that it met. A missed target is no failure. Parts
of speed begin with an empty cache. ``--quick`` shows in minutes that they work.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from timing import table

TARGETS = re.compile(r"\(target.*\b(met|MISSED)\b")


@dataclass(frozen=True)
class Part:
    """A benchmark of the list.

    Parameters
    ----------
    name : str
        Name of its module in this folder.
    options : tuple of str
        Options of a whole run.
    picture : str
        File of its plot in the folder of results; empty where it draws none.
    """

    name: str
    options: tuple[str, ...] = ()
    picture: str = ""


SPEED = (
    Part("ingest_mcap"),
    Part("random_access", ("--frames", "600", "--batches", "8")),
    Part("epochs"),
    Part("scale_splits"),
    Part("gel_speed", ("--touches", "26")),
    Part("inference"),
    Part("calibration", ("--low", "--fidelity", "finite-strain", "--seeds", "1", "--draws", "200", "--workers", "2")),
    Part("diagnose_speed", ("--touches", "36", "--own-pad")),
    Part("diagnose_speed", ("--touches", "60", "--own-pad")),
    Part("estimated_plays", ("--quick",)),
    Part("gel_growth", picture="gel-growth.png"),
    Part("plays_growth", picture="plays-growth.png"),
    Part("replay_memory"),
)
ACCURACY = (
    Part("linear_error"),
    Part("gel_mesh_error"),
    Part("solver_difference"),
    Part("shear_between_plays"),
    Part("calibration_worlds"),
    Part("locating_worlds"),
    Part("naming_worlds"),
)
LISTS = {"speed": SPEED, "accuracy": ACCURACY}


@dataclass(frozen=True)
class Outcome:
    """How a part ended.

    Parameters
    ----------
    title : str
        Its name and its options.
    minutes : float
        How long it ran.
    code : int
        Code with which its process ended.
    targets : list of str
        ``"met"`` or ``"MISSED"`` for each target that it printed.
    """

    title: str
    minutes: float
    code: int
    targets: list[str]

    @property
    def row(self) -> tuple[str, str, str, str]:
        """Its row of the table at the end."""
        met = f"{self.targets.count('met')} of {len(self.targets)}" if self.targets else "none stated"
        return self.title, f"{self.minutes:.1f}", met, "yes" if self.code == 0 else f"failed ({self.code})"


def main() -> int:
    """Run them; 1 where one failed to run."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--what", choices=sorted(LISTS), default="speed")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="only parts of these names")
    parser.add_argument("--out", type=Path, default=Path("bench-out"), help="folder of what is kept")
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    names = list(dict.fromkeys(part.name for part in LISTS[options.what]))
    if unknown := [name for name in options.only or [] if name not in names]:
        parser.error(f"{', '.join(unknown)}: no part has such a name; there are {', '.join(names)}")
    parts = [part for part in LISTS[options.what] if not options.only or part.name in options.only]
    options.out.mkdir(parents=True, exist_ok=True)
    outcomes = []
    for number, part in enumerate(parts, 1):
        with tempfile.TemporaryDirectory() as cache:
            environment = {**os.environ, "TACTILEDATA_CACHE": cache} if options.what == "speed" else None
            log = options.out / f"{number:02d}-{part.name}.txt"
            outcomes.append(ran(part, log, is_quick=options.quick, environment=environment))
    print(f"\n## {options.what}: {sum(one.minutes for one in outcomes):.0f} minutes, kept in {options.out}")
    table(("part", "minutes", "targets met", "ran"), [one.row for one in outcomes])
    return int(any(one.code for one in outcomes))


def ran(part: Part, log: Path, *, is_quick: bool, environment: dict[str, str] | None) -> Outcome:
    """Run a part in a process of its own; show and keep what it prints.

    Parameters
    ----------
    part : Part
        What is run.
    log : Path
        Where its lines are kept.
    is_quick : bool
        Whether its quick form is asked for.
    environment : dict, optional
        Its environment; ours where ``None``.
    """
    drawn = ("--picture", str(log.parent / part.picture)) if part.picture else ()
    script = Path(__file__).resolve().parent / f"{part.name}.py"
    options = [*(("--quick",) if is_quick else part.options), *drawn]
    began, targets = time.monotonic(), []
    with (
        log.open("w", encoding="utf-8") as kept,
        subprocess.Popen(
            [sys.executable, "-u", script, *options],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        ) as process,
    ):
        assert process.stdout is not None
        for line in process.stdout:
            sys.stdout.write(line)
            sys.stdout.flush()
            kept.write(line)
            targets += TARGETS.findall(line)
        code = process.wait()
    return Outcome(" ".join([script.name, *options]), (time.monotonic() - began) / 60.0, code, targets)


if __name__ == "__main__":
    sys.exit(main())
