"""The mutation score: the share of small changes to the code that its fast tests notice.

Cosmic Ray makes the changes; this script draws a sample of them, chooses the tests that run the changed line, and
counts. Of each package so many places are drawn, and at each place one change: `make mutants`. What was measured is
kept in a folder, so that a run that was stopped goes on where it was. Changes that no test could notice are listed
with the reason in equivalent_mutants.yaml. The choice of the tool is described in docs/decisions/0033-mutants.md.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import yaml
from mutant_runs import Copy, fork_tests, load_libraries
from mutant_sites import Mutant, changed_lines, sample
from mutant_tests import TestMap

from tactiledata.prove.score.wilson import interval

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = {
    "contract": ["tactiledata/contract"],
    "ingest": ["tactiledata/ingest"],
    "splits": ["tactiledata/splits"],
    "metrics": ["tactiledata/metrics"],
    "losses": [
        "tactiledata/calibrate/losses.py",
        "split_models/learning/objectives.py",
        "split_models/networks/latent_normal.py",
    ],
    "effects": ["tactiledata/effects"],
}
TESTS = (
    "contract", "ingest", "splits", "metrics", "effects", "calibrate", "split_models", "store", "scoring",
    "test_house.py", "test_families.py",
)  # fmt: skip
"""Folders and files below tests whose fast tests are used."""
OWN_TESTS = {"losses": ("calibrate", "split_models")}
"""Folders of tests of packages whose folder has another name than the package."""
EVERYBODYS_TESTS = ("test_house.py", "test_families.py")
"""Tests that read the sources of every package, or everything that is registered."""
KILLED, SURVIVED, EQUIVALENT = "killed", "survived", "equivalent"


@dataclass(frozen=True)
class Result:
    """What became of a mutant."""

    mutant: Mutant
    outcome: str
    reason: str


def files_of(package: str) -> list[str]:
    """Paths of a package's modules, relative to the repository."""
    found: list[Path] = []
    for place in PACKAGES[package]:
        found += sorted((ROOT / place).rglob("*.py")) if (ROOT / place).is_dir() else [ROOT / place]
    return [str(path.relative_to(ROOT)) for path in found]


def test_files(names: Iterable[str]) -> list[str]:
    """Paths, relative to the repository, of the test files of these folders or files below ``tests``."""
    found: list[Path] = []
    for name in names:
        place = ROOT / "tests" / name
        found += sorted(place.rglob("test_*.py")) if place.is_dir() else [place]
    return [str(path.relative_to(ROOT)) for path in found]


def equivalents() -> dict[tuple[str, str, str], str]:
    """Reasons of the listed equivalent mutants, by file, line and changed line."""
    rows = yaml.safe_load((ROOT / "benchmarks" / "equivalent_mutants.yaml").read_text()) or []
    return {(row["file"], row["line"], row["changed"]): row["reason"] for row in rows}


def own_tests(package: str) -> list[str]:
    """Paths of the test files that are run for what a package does when it is imported, whatever lines they run."""
    return test_files([*OWN_TESTS.get(package, (package,)), *EVERYBODYS_TESTS])


def measured(mutants: list[Mutant], tests: TestMap, own: list[str], copy: Copy, kept: Path) -> Iterator[Result]:
    """Outcomes of mutants, those that were measured with the same tests from the file that keeps them."""
    listed = equivalents()
    rows = [json.loads(line) for line in kept.read_text().splitlines()] if kept.exists() else []
    known = {row["mutant"]: row for row in rows}
    for mutant in mutants:
        if (mutant.file, mutant.line, mutant.changed) in listed:
            yield Result(mutant, EQUIVALENT, listed[mutant.file, mutant.line, mutant.changed])
            continue
        chosen = tests.running(mutant, own)
        row = known.get(mutant.key)
        if row is None or row["digest"] != tests.digest([row["by"]] if row["by"] else chosen):
            row = {"mutant": mutant.key, **_run(mutant, chosen, tests, copy)}
            with kept.open("a") as file:
                file.write(json.dumps(row) + "\n")
        yield Result(mutant, row["outcome"], row["reason"])


def _run(mutant: Mutant, chosen: list[str], tests: TestMap, copy: Copy) -> dict[str, str]:
    """Outcome, reason, the test that noticed, and the digest of the test files that the outcome rests on."""
    if not chosen:
        return {"outcome": SURVIVED, "reason": "no fast test runs this line", "by": "", "digest": tests.digest([])}
    with copy.changed(mutant.file, mutant.text):
        code, by = fork_tests(copy.place, chosen, 60 + 10 * tests.seconds(chosen))
    outcome, reason = SURVIVED if code == 0 else KILLED, "time ran out" if code is None else ""
    return {"outcome": outcome, "reason": reason, "by": by, "digest": tests.digest([by] if by else chosen)}


def describe(result: Result) -> str:
    """A survivor for people: where it is, and what was changed."""
    mutant = result.mutant
    reason = f" ({result.reason})" if result.reason else ""
    return f"{mutant.file}:{mutant.row}: {result.outcome}{reason}\n  - {mutant.line}\n  + {mutant.changed}"


def summary(package: str, results: list[Result], places: int) -> str:
    """A row of the table of scores."""
    equivalent = sum(result.outcome == EQUIVALENT for result in results)
    killed = sum(result.outcome == KILLED for result in results)
    count = len(results) - equivalent
    low, high = interval(killed, count)
    share = killed / count if count else 0.0
    return (
        f"{package:<10} {places:>6} {len(results):>6} {equivalent:>10} {killed:>6} {count - killed:>8} "
        f"{share:>6.1%}  {low:.1%} to {high:.1%}"
    )


def main() -> None:
    """Measure the score and print survivors."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("packages", nargs="*", default=list(PACKAGES), help=f"of {', '.join(PACKAGES)}")
    parser.add_argument("--sample", type=int, default=60, help="places drawn of each package; 0: every place")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tests", nargs="+", default=list(TESTS), help="folders or files below tests that are used")
    parser.add_argument("--since", metavar="COMMIT", help="only lines that are new or other than at this commit")
    parser.add_argument("--work", type=Path, default=ROOT / ".mutants", help="folder that keeps what was measured")
    options = parser.parse_args()
    if unknown := set(options.packages) - set(PACKAGES):
        parser.error(f"no package {', '.join(sorted(unknown))}; there are {', '.join(PACKAGES)}")
    options.work.mkdir(parents=True, exist_ok=True)
    load_libraries()
    sources = [file for package in PACKAGES for file in files_of(package)]
    copy = Copy(ROOT, options.work / f"copy-{'-'.join(options.packages)}")
    tests = TestMap.measured(copy.place, test_files(options.tests), sources, options.work / "tests")
    if not any(tests.lines.values()):
        parser.error(f"no fast test of {', '.join(options.tests)} runs a line of {', '.join(options.packages)}")
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True)
    only = changed_lines(ROOT, options.since) if options.since else None
    rows, everything = [], []
    for package in options.packages:
        mutants, count = sample(ROOT, files_of(package), options.sample, f"{options.seed} {package}", only)
        results = []
        for result in measured(mutants, tests, own_tests(package), copy, options.work / f"{package}.jsonl"):
            results.append(result)
            if result.outcome != KILLED:
                print(f"[{len(results)}/{len(mutants)}] {describe(result)}", flush=True)
        rows.append(summary(package, results, count))
        print(rows[-1], file=sys.stderr, flush=True)
        everything += [(package, result) for result in results]
    since = f", lines changed since {options.since}" if options.since else ""
    places = f"{options.sample} places a package, seed {options.seed}" if options.sample else "every place"
    print(f"\nmutation score, commit {commit.stdout.strip()}, {places}{since}")
    print("package    places sample equivalent killed survived  score  95 % interval")
    print("\n".join(rows))
    print(summary("all", [result for _, result in everything], 0).replace("      0", "       ", 1))


if __name__ == "__main__":
    main()
