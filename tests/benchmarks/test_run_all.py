"""The list of benchmarks: every part is there, what it prints is kept, and targets are counted."""

import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "benchmarks"


@pytest.fixture(scope="module")
def run_all():
    """The module of the list, as it is imported from its folder."""
    sys.path.insert(0, str(FOLDER))
    try:
        import run_all

        yield run_all
    finally:
        sys.path.remove(str(FOLDER))


def test_every_part_has_a_benchmark(run_all):
    """Each part names a module of the folder, and each option of a whole run is one that the module knows."""
    for part in (*run_all.SPEED, *run_all.ACCURACY):
        source = (FOLDER / f"{part.name}.py").read_text(encoding="utf-8")
        named = [option for option in part.options if option.startswith("--")] + ["--picture"] * bool(part.picture)
        assert all(f'"{option}"' in source for option in [*named, "--quick"]), part


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("ours against theirs: 1.43 (target: at least 1.2) met", ["met"]),
        ("ours against theirs: 0.88 (target: at least 1.2) MISSED", ["MISSED"]),
        ("split and audit: 3.1 s (target 20 s: met)", ["met"]),
        ("what was met before", []),
    ],
)
def test_targets_are_counted(run_all, line, found):
    """A line that ends with the verdict on a target counts as one; other lines do not."""
    assert run_all.TARGETS.findall(line) == found


def test_a_run_keeps_what_it_printed(tmp_path):
    """Lines of a part are shown and kept; the table at the end has its minutes, its targets and how it ended."""
    asked = [sys.executable, FOLDER / "run_all.py", "--quick", "--only", "scale_splits", "--out", tmp_path / "kept"]
    done = subprocess.run(asked, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    kept = (tmp_path / "kept" / "01-scale_splits.txt").read_text(encoding="utf-8")
    assert "(target 2 GB: met)" in kept
    assert kept in done.stdout
    name, option, _, *counted = done.stdout.splitlines()[-1].split()
    assert (name, option, counted) == ("scale_splits.py", "--quick", ["2", "of", "2", "yes"])


@pytest.mark.parametrize("asked", [["everything"], ["scale_splits", "everything"]])
def test_an_unknown_part_is_named(asked, tmp_path):
    """A name that no part has ends the run before any part, with the names that there are."""
    command = [sys.executable, FOLDER / "run_all.py", "--quick", "--out", tmp_path / "kept", "--only", *asked]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 2
    assert "everything: no part has such a name; there are ingest_mcap" in done.stderr
    assert not (tmp_path / "kept").exists()


def test_a_failing_part_fails_the_run(run_all, tmp_path, monkeypatch):
    """The code of a part that fails is told, and what it printed is kept."""
    monkeypatch.setattr(run_all, "__file__", str(tmp_path / "run_all.py"))
    (tmp_path / "broken.py").write_text("print('before the end')\nraise SystemExit(3)\n")
    outcome = run_all.ran(run_all.Part("broken"), tmp_path / "log.txt", is_quick=False, environment=None)
    assert outcome.code == 3
    assert outcome.row[2:] == ("none stated", "failed (3)")
    assert (tmp_path / "log.txt").read_text() == "before the end\n"
