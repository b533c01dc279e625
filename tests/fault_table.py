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


def listed():
    """The list: writers by name, each with its tests by fault, or with the name of a reason why there can be none."""
    return yaml.safe_load(LIST.read_text(encoding="utf-8"))["writers"]


def reasons():
    """The reasons why a fault cannot meet a writer, by their names in the list."""
    return yaml.safe_load(LIST.read_text(encoding="utf-8"))["reasons"]


def cell(found):
    """What a cell says of its tests."""
    if isinstance(found, str):
        return "–"
    return f"{len(found)} test{'s'[: len(found) > 1]}" if found else "**not tested**"


def told(found, why):
    """What stands below the table on a cell: its tests, or the reason why there can be none."""
    if isinstance(found, str):
        return why[found]
    return ", ".join(f"`{node.removeprefix('tests/')}`" for node in found)


def drawn():
    """The table, and the tests below it."""
    writers, why = listed(), reasons()
    lines = [f"| writer | {' | '.join(FAULTS.values())} |", f"|---|{'---|' * len(FAULTS)}"]
    lines += [
        f"| {name} | {' | '.join(cell(entry.get(fault, [])) for fault in FAULTS)} |" for name, entry in writers.items()
    ]
    missing = sum(cell(entry.get(fault, [])) == "**not tested**" for entry in writers.values() for fault in FAULTS)
    dashes = sum(cell(entry.get(fault, [])) == "–" for entry in writers.values() for fault in FAULTS)
    total = len(writers) * len(FAULTS)
    without = "No cell is" if not missing else f"{missing} of {total} cells are"
    lines += ["", f"{without} without a test that could have one. In {dashes} of {total} the fault cannot come."]
    lines += ["", "The tests by writer, and the reasons:", ""]
    for writer, entry in writers.items():
        lines.append(f"- **{writer}**")
        for fault, words in FAULTS.items():
            if found := entry.get(fault, []):
                lines.append(f"    - {words}: {told(found, why)}")
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
