"""The table of faults in docs/reliability.md, drawn from docs/reliability.yaml, which names a test for each cell.

``python tests/fault_table.py --write`` draws it anew. A test holds the page to the list, and the list to the tests.
"""

import ast
import re
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[1]
PAGE, LIST = ROOT / "docs" / "reliability.md", ROOT / "docs" / "reliability.yaml"
START, STOP = "<!-- faults: drawn by tests/fault_table.py -->\n", "<!-- end of faults -->\n"
FAULTS = {
    "killed": "killed (signal 9)",
    "full": "disk full",
    "read-only": "read-only",
    "worker": "worker lost",
    "two": "two writers",
}
"""Columns, as the list names them and as the page heads them."""
NODE = re.compile(r"(?P<file>tests/[\w/]+\.py)::(?P<name>test_\w+)(\[(?P<case>[\w-]+)\])?")
NO_WORKERS = "no workers"
"""What the list says in place of tests where a writer starts no workers."""


def listed():
    """The list: writers by name, each with its tests by fault."""
    return yaml.safe_load(LIST.read_text(encoding="utf-8"))["writers"]


def cell(found):
    """What a cell says of its tests."""
    if found == NO_WORKERS:
        return "–"
    return f"{len(found)} test{'s'[: len(found) > 1]}" if found else "**not tested**"


def drawn():
    """The table, and the tests below it."""
    writers = listed()
    lines = [f"| writer | {' | '.join(FAULTS.values())} |", f"|---|{'---|' * len(FAULTS)}"]
    lines += [
        f"| {name} | {' | '.join(cell(entry.get(fault, [])) for fault in FAULTS)} |" for name, entry in writers.items()
    ]
    missing = sum(cell(entry.get(fault, [])) == "**not tested**" for entry in writers.values() for fault in FAULTS)
    lines += ["", f"{missing} of {len(writers) * len(FAULTS)} cells are not tested. The tests by writer:", ""]
    for writer, entry in writers.items():
        lines.append(f"- **{writer}**")
        for fault, words in FAULTS.items():
            if (found := entry.get(fault, [])) and found != NO_WORKERS:
                names = (node.removeprefix("tests/") for node in found)
                lines.append(f"    - {words}: {', '.join(f'`{name}`' for name in names)}")
    return "\n".join(lines) + "\n"


def drawn_page(text):
    """A page with the table in its place."""
    head, _, rest = text.partition(START)
    return f"{head}{START}\n{drawn()}\n{STOP}{rest.partition(STOP)[2]}"


def absent(node):
    """Why a test that the list names cannot be one that runs; empty where it can."""
    found = NODE.fullmatch(node)
    if not found:
        return "is no name of a test"
    place = ROOT / found["file"]
    if not place.is_file():
        return "is in no file"
    source = place.read_text(encoding="utf-8")
    names = {one.name for one in ast.walk(ast.parse(source)) if isinstance(one, ast.FunctionDef)}
    return "" if found["name"] in names else "is in no function"


if __name__ == "__main__":
    if "--write" in sys.argv[1:]:
        PAGE.write_text(drawn_page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    else:
        print(drawn())
