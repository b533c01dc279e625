"""A row for each sealed ensemble on the page of ensembles: what was asked, and what its printed score says.

    python benchmarks/proof_table.py            prints the table
    python benchmarks/proof_table.py --write    writes it into the page, below "## All ensembles"

Nothing is computed anew: counts are those that `tactiledata prove` printed, which the page holds in full.
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs" / "proof-ensembles.md"
HEADING = "## All ensembles"
COUNTS = {
    "nulls named": "false alarms on nulls",
    "wrong names": "wrong names",
    "visible effects named": "visible effects named",
}
"""Columns, and the first words of the printed lines that they are from."""
RULES = {
    "A thirty-sixth ensemble": "the rules of decision 0107",
    "A thirty-fourth ensemble": "the rules of decision 0106",
    "A thirtieth ensemble": "the worlds of decision 0100",
    "A twenty-sixth ensemble": "the rules of decision 0096",
    "A twenty-third ensemble": "the rules of decision 0093",
    "A seventeenth ensemble": "the rules of 28 and 29 November",
}
"""The first ensemble of each set of rules, the newest first: those from it on, up to the next set, are summed."""
CHOSEN = " (chosen)"
"""Stands behind counts of effects that the command chose (``--effects``); they are in no sum, as they are no sample."""


def slug(heading: str) -> str:
    """Anchor of a heading, as Markdown readers make it."""
    return re.sub(r"[^a-z0-9 -]", "", heading.lower()).replace(" ", "-")


def option(command: str, name: str) -> str:
    """Value of an option of a printed command, or a dash."""
    found = re.search(rf"--{name} (\S+)", command)
    return found.group(1).replace(",", ", ") if found else "-"


def rows(page: str) -> list[tuple[str, ...]]:
    """Heading, generators, plans, commit, date and counts of every section with a score and a root.

    Counts of chosen effects are marked; nulls hide none, so that theirs are not.
    """
    found = []
    for section in re.split(r"(?m)^(?=## )", page):
        heading = section.partition("\n")[0].removeprefix("## ")
        counts = [re.search(rf"(?m)^{words} .* (\d+ of \d+) ", section) for words in COUNTS.values()]
        command = re.search(r"(?m)^`(tactiledata prove --[^`]*)`, commit (\w+), ([\d-]+)", section)
        if command and "--quick" not in command.group(1) and any(counts):
            what, commit, date = command.groups()
            told = [count.group(1) if count else "-" for count in counts]
            if "--effects" in what:
                told[1:] = [count if count == "-" else count + CHOSEN for count in told[1:]]
            generators, plans = option(what, "generators"), option(what, "plans")
            found.append((f"[{heading}](#{slug(heading)})", generators, plans, commit, date, *told))
    return found


def summed(found: list[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """The sums of the counts of ensembles that one set of rules decided, a row for each set that has any.

    The newest ensembles come first.
    """
    sums, newer = [], 0
    for first, rules in RULES.items():
        places = [place for place, row in enumerate(found) if row[0].startswith(f"[{first}")]
        if not places:
            continue
        same, newer = found[newer : places[0] + 1], places[0] + 1
        counts = []
        for column in range(-len(COUNTS), 0):
            counted = [row[column] for row in same if row[column] != "-" and not row[column].endswith(CHOSEN)]
            pairs = [tuple(map(int, count.split(" of "))) for count in counted]
            counts.append(f"{sum(few for few, _ in pairs)} of {sum(all_ for _, all_ in pairs)}")
        ensembles = "the ensemble" if len(same) == 1 else f"the {len(same)} ensembles"
        sums.append((f"**{ensembles} with {rules}**", "", "", "", "", *counts))
    return sums


def table(page: str) -> str:
    """The table as Markdown."""
    head = ("ensemble", "generators", "plan", "commit", "date", *COUNTS)
    found = rows(page)
    lines = [head, ("---",) * len(head), *summed(found), *found]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def with_table(page: str) -> str:
    """The page with the table in its place: below the words under its heading, in place of an older one."""
    before, heading, after = page.partition(f"{HEADING}\n")
    section, end, others = after.partition("\n## ")
    words = "\n".join(line for line in section.splitlines() if not line.startswith("|")).strip()
    return f"{before}{heading}{words}\n\n{table(page)}\n{end}{others}"


def main() -> None:
    """Print the table, or write it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true")
    page = PAGE.read_text()
    if parser.parse_args().write:
        PAGE.write_text(with_table(page))
    else:
        print(table(page))


if __name__ == "__main__":
    main()
