"""Tables of docs/results.md as JSON: as the page shows them, no row more and none less."""

import json
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PRINTED = """
```text
## speed of both
2 cores, 25 GB
way          frames/s  as fast
-----------  --------  -------
ours            1,234     1.50
theirs, two       823     1.00
values: equal
ours against theirs: 1.50 (target: at least 1.0) met
```

| what | error, % |
|---|---:|
| force | 0.34 |
| slope | over 5 |

Words beside the tables.
"""


@pytest.fixture(scope="module")
def tables():
    """The program that writes the files."""
    sys.path.insert(0, str(ROOT / "benchmarks"))
    try:
        import results_tables

        yield results_tables
    finally:
        sys.path.remove(str(ROOT / "benchmarks"))


def test_tables_and_lines_are_told_in_their_order(tables):
    """A printed table, the lines about it, and a table of the page: columns, numbers as numbers, and texts."""
    lines = tables.section_lines(f"# Results\n\n## One\n{PRINTED}\n## Two\n\n| a | b |\n|---|---|\n| 1 | 2 |\n", "One")
    assert list(tables.printed(lines)) == [
        {"line": "## speed of both"},
        {"line": "2 cores, 25 GB"},
        {"columns": ["way", "frames/s", "as fast"], "rows": [["ours", 1234.0, 1.5], ["theirs, two", 823.0, 1.0]]},
        {"line": "values: equal"},
        {"line": "ours against theirs: 1.50 (target: at least 1.0) met"},
        {"columns": ["what", "error, %"], "rows": [["force", 0.34], ["slope", "over 5"]]},
    ]


def test_the_files_are_as_the_page(tables):
    """Each section without JSON of its own has a file that says what the page says, and there is no other file."""
    made = tables.printed_files(tables.PAGE.read_text(encoding="utf-8"))
    there = {path.name: path.read_text(encoding="utf-8") for path in tables.FOLDER.iterdir()}
    assert made == there, "run `python benchmarks/results_tables.py`"
    sections = {one["heading"]: one for one in tables.listed()}
    documents = [json.loads(text) for text in there.values()]
    assert sorted(one["section"] for one in documents) == sorted(
        heading for heading, one in sections.items() if not one.get("json")
    )
    for one in documents:
        assert one["printed"], one["section"]
        assert [one[key] for key in ("command", "commit")] == [
            sections[one["section"]][key] for key in ("command", "commit")
        ]
