"""The effect of tests/examples, to which the laws of the family apply as to every other."""

import importlib.util
import sys
from pathlib import Path

from tactiledata.effects import EFFECTS

EXAMPLE = "backlash"
EVERY_EFFECT = [*EFFECTS, EXAMPLE]
"""Names of all effects, and of the example, which the fixture ``name`` adds to the table."""
TARGET = f"{EXAMPLE}:Backlash"


def load_example(monkeypatch):
    """Import the example by its path, as an installed package would be imported by its name."""
    path = Path(__file__).parents[1] / "examples" / f"{EXAMPLE}.py"
    spec = importlib.util.spec_from_file_location(EXAMPLE, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setitem(sys.modules, EXAMPLE, module)


def add_by_line(monkeypatch):
    """Add the example as a line in the table does."""
    load_example(monkeypatch)
    monkeypatch.setitem(EFFECTS._table, EXAMPLE, TARGET)


def add_by_entry_point(monkeypatch):
    """Add the example as the entry point of another package does."""
    load_example(monkeypatch)
    monkeypatch.setitem(vars(EFFECTS), "_outside", {EXAMPLE: TARGET})
