"""The benchmarks run: their quick form ends well, whatever it measures."""

import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "benchmarks"


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["random_access.py", "ingest_mcap.py", "epochs.py"])
def test_quick_benchmarks_end_well(name, tmp_path):
    """A benchmark's quick form exits with 0 from any folder, having found equal pixels and printed its verdicts."""
    done = subprocess.run(
        [sys.executable, FOLDER / name, "--quick"],
        cwd=tmp_path,
        env={"PATH": "", "PYTHONPATH": str(FOLDER.parent)},
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert done.stdout.count("(target:") == (4 if name == "epochs.py" else 2)
    assert "pixels: equal" in done.stdout or name != "random_access.py"
    assert "values: equal" in done.stdout or name != "epochs.py"
