"""The printed tables of docs/results.md as JSON, for sections whose benchmark writes none itself.

    python benchmarks/results_tables.py            write docs/results/printed
    python benchmarks/results_tables.py --check    say which files are not as the page

A file has the section's command, commit and date, and what the page shows between fences or in tables, in its order: a
table with its columns and rows, or a line. Cells that are numbers are numbers.
"""

from __future__ import annotations

import argparse
import itertools
import json
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from proof_table import slug
from results_age import PAGE, ROOT, listed, page_lines

from tactiledata.contract.atomic import write_atomic

FOLDER = PAGE.parent / "results" / "printed"
NUMBER = re.compile(r"[+-]?\d[\d,]*(\.\d+)?(e[+-]?\d+)?")
RULE = re.compile(r"-+(  +-+)+")
"""The line below the columns of a table that `timing.table` prints."""
MARKDOWN_RULE = re.compile(r"\|(:?-+:?\|)+")


def main() -> int:
    """Write the files, or compare; 1 where one differs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    is_check = parser.parse_args().check
    made = printed_files(PAGE.read_text(encoding="utf-8"))
    there = {path.name: path.read_text(encoding="utf-8") for path in FOLDER.glob("*.json")}
    differing = sorted(name for name in {*made, *there} if made.get(name) != there.get(name))
    if is_check:
        print("\n".join(differing) or "all files are as the page")
        return int(bool(differing))
    FOLDER.mkdir(exist_ok=True)
    for name in differing:
        if name in made:
            write_atomic(FOLDER / name, made[name].encode())
        else:
            (FOLDER / name).unlink()
    print(f"{len(made)} files in {FOLDER.relative_to(ROOT)}, {len(differing)} of them new or changed")
    return 0


def printed_files(page: str) -> dict[str, str]:
    """Return the text of each file by its name, for the sections of the list that keep no JSON of their own."""
    files = {}
    for one in listed():
        if one.get("json"):
            continue
        document = {
            "section": one["heading"],
            **{key: one[key] for key in ("command", "commit", "date")},
            "printed": list(printed(section_lines(page, one["heading"]))),
        }
        files[f"{slug(one['heading'])}.json"] = json.dumps(document, indent=1, ensure_ascii=False) + "\n"
    return files


def section_lines(page: str, heading: str) -> list[tuple[str, bool]]:
    """Return the lines below a heading, up to the next one, each with whether it is printed output between fences."""
    found: list[tuple[str, bool]] = []
    is_in = False
    for line, is_output in page_lines(page):
        if line.startswith("## ") and not is_output:
            is_in = line == f"## {heading}"
        elif is_in:
            found.append((line, is_output))
    return found


def printed(lines: list[tuple[str, bool]]) -> Iterator[dict[str, Any]]:
    """Yield tables and lines of printed output, and tables beside it.

    Parameters
    ----------
    lines : list of (str, bool)
        Lines of a section, each with whether it is printed output.
    """
    place = 0
    while place < len(lines):
        line, is_output = lines[place]
        below = lines[place + 1][0] if place + 1 < len(lines) else ""
        if MARKDOWN_RULE.fullmatch(below):
            rows = _until(lines, place + 2, lambda text: text.startswith("|"))
            yield {"columns": _of_markdown(line), "rows": [_values(_of_markdown(row)) for row in rows]}
            place += 2 + len(rows)
        elif is_output and RULE.fullmatch(below):
            spans = [match.span() for match in re.finditer(r"-+", below)]
            rows = _until(lines, place + 2, lambda text, spans=spans: _has_gaps(text, spans))
            cells = [[row[start:end].strip() for start, end in spans] for row in [line, *rows]]
            yield {"columns": cells[0], "rows": [_values(row) for row in cells[1:]]}
            place += 2 + len(rows)
        else:
            if is_output and line.strip() and not line.startswith("```"):
                yield {"line": line}
            place += 1


def _until(lines: list[tuple[str, bool]], start: int, belongs: Callable[[str], bool]) -> list[str]:
    """Return the lines from a place on that belong to a table."""
    return [line for line, _ in itertools.takewhile(lambda one: belongs(one[0]), lines[start:])]


def _has_gaps(row: str, spans: Sequence[tuple[int, int]]) -> bool:
    """Return whether a line has something in the first column of a table and beyond it, and nothing between columns."""
    between = [*((end, start) for (_, end), (start, _) in itertools.pairwise(spans)), (spans[-1][1], len(row))]
    first = spans[0][1]
    return bool(row[:first].strip() and row[first:].strip()) and not any(
        row[start:end].strip() for start, end in between
    )


def _of_markdown(row: str) -> list[str]:
    """Return the cells of a row between bars."""
    return [cell.strip() for cell in row.strip().strip("|").split("|")]


def _values(cells: list[str]) -> list[str | float]:
    """Return cells, numbers as numbers."""
    return [float(cell.replace(",", "")) if NUMBER.fullmatch(cell) else cell for cell in cells]


if __name__ == "__main__":
    sys.exit(main())
