"""Print what keeps effects from being named in all sealed ensembles, and how often the right one stands behind it.

    python benchmarks/proof_objections.py [--each OBJECTION]

Reads the misses that `tactiledata prove` printed, which docs/proof-ensembles.md holds in full: effects of the catalogue
that got no name, with the effects whose refit came nearest, and the objections to it. They are counted by the first
objection. Where the right effect is nearly always nearest, the objection keeps right names back; where it seldom is, it
keeps wrong ones back. `--each` lists the misses of one objection, `--each share` for example. Nothing is computed anew,
and rules changed between ensembles. Answers that name nothing in worlds without effects are no misses: what an
objection keeps back there is not seen here.
"""

from __future__ import annotations

import argparse
import re
import statistics
from dataclasses import dataclass

from proof_table import PAGE
from timing import table

from tactiledata.prove.cases.truth import TITLES

OBJECTIONS = {
    "evidence": r"errors of the simulation alone can bring up to",
    "two trajectories": r"without the two trajectories that contribute",
    "gain": r"the gain on held-out trajectories",
    "indenters": r"held-out indenters are predicted worse",
    "share": r"of the excess over the noise is gone, and more than the noise",
    "least share": r"of the excess over the noise is gone in data",
    "agreement": r"the trajectories do not agree",
    "signature": r"the residual still holds",
    "bound of nu": r"stands at an end of the range",
    "trend": r"its strength changes during the session",
    "plausible": r"is not plausible",
    "crowd": r"other effects explain nearly as much",
    "outweighed": r"cannot be claimed",
}
"""Objections by a word, and what their sentences say."""
MISS = re.compile(
    r"(?m)^miss: (?P<case>\w+) \((?P<kind>\w+); (?P<where>[^)]*)\): (?P<hidden>.*?) with a signal of (?P<signal>[\d.]+)"
    r" was answered with .*?\. Nearest: (?P<nearest>[^.]*)\. Against it: (?P<against>.*)$"
)


@dataclass(frozen=True)
class Miss:
    """An effect, or two, that got no name.

    Parameters
    ----------
    case : str
        Name of the case, and its configuration.
    hidden, nearest : tuple of str
        What is hidden and what came nearest, as the catalogue calls it.
    signal : float
        Signal of what is hidden.
    objection : str
        The first objection, by its word.
    """

    case: str
    hidden: tuple[str, ...]
    nearest: tuple[str, ...]
    signal: float
    objection: str

    @property
    def is_right(self) -> bool:
        """Whether all that came nearest is hidden."""
        return set(self.nearest) <= set(self.hidden)


def misses(page: str) -> list[Miss]:
    """Return the misses on a page to which there is an objection, each case once, by its last line on the page."""
    found: dict[str, Miss] = {}
    for one in MISS.finditer(page):
        places = {word: re.search(said, one["against"]) for word, said in OBJECTIONS.items()}
        first = min((place.start(), word) for word, place in places.items() if place)[1]
        hidden = tuple(TITLES.get(name, name) for name in one["hidden"].split(" + "))
        name = f"{one['case'][:8]} {one['where']}"
        found[one["case"]] = Miss(name, hidden, tuple(one["nearest"].split(" + ")), float(one["signal"]), first)
    return list(found.values())


def print_tables(found: list[Miss], each: str = "") -> None:
    """Print a line an objection, the one that keeps most back first; then every miss of one objection."""
    rows = []
    for word in sorted({miss.objection for miss in found}, key=lambda w: -sum(m.objection == w for m in found)):
        mine = [miss for miss in found if miss.objection == word]
        right = sum(miss.is_right for miss in mine)
        rows.append((word, len(mine), right, f"{statistics.median(miss.signal for miss in mine):.0f}"))
    table(("first objection", "misses", "right one nearest", "median signal"), rows)
    if each:
        table(("case", "hidden", "nearest", "signal"), [
            (miss.case, " + ".join(miss.hidden), " + ".join(miss.nearest), f"{miss.signal:.0f}")
            for miss in found if miss.objection == each
        ])  # fmt: skip


def main() -> None:
    """Read the page and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--each", choices=OBJECTIONS, default="")
    print_tables(misses(PAGE.read_text()), parser.parse_args().each)


if __name__ == "__main__":
    main()
