"""SECURITY.md states the limits that the code has."""

import importlib
import re
from pathlib import Path

PAGE = Path(__file__).resolve().parents[1] / "SECURITY.md"
ROW = re.compile(r"^\| [^|]+ \| (?P<value>[\d.]+) \| `(?P<module>[\w.]+):(?P<name>\w+)` \|$", re.MULTILINE)


def test_limits_are_those_of_the_code():
    """Every row of the table has the value of the constant that it names."""
    rows = list(ROW.finditer(PAGE.read_text(encoding="utf-8")))
    assert len(rows) > 10
    stated = {f"{row['module']}:{row['name']}": float(row["value"]) for row in rows}
    found = {place: getattr(importlib.import_module(place.split(":")[0]), place.split(":")[1]) for place in stated}
    assert stated == found
