"""Tests of a changed copy of the repository import the copy, whatever the process before them had loaded."""

import importlib.util
import sys
from pathlib import Path

import pytest

import tactiledata.errors  # noqa: F401 - loaded before the copy

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.slow
@pytest.mark.parametrize(("text", "code"), [("ANSWER = 42", 0), ("ANSWER = 41", 1)])
def test_the_copy_is_tested_though_the_package_was_loaded_before(tmp_path, text, code):
    """A test in a forked process sees the module of the copy, and not that of the toolkit which was loaded before."""
    assert "tactiledata.errors" in sys.modules
    spec = importlib.util.spec_from_file_location("mutant_runs", ROOT / "benchmarks" / "mutant_runs.py")
    runs = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(runs)
    (tmp_path / "tactiledata").mkdir()
    (tmp_path / "tactiledata" / "__init__.py").touch()
    (tmp_path / "tactiledata" / "errors.py").write_text(text)
    (tmp_path / "test_copy.py").write_text(
        "from tactiledata.errors import ANSWER\n\n\ndef test_answer():\n    assert ANSWER == 42\n"
    )
    found, failed = runs.fork_tests(tmp_path, ["test_copy.py"], 60.0)
    assert found == code, (tmp_path / "last-run.txt").read_text()
    assert ("test_answer" in failed) == bool(code)
