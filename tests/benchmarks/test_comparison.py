"""What docs/comparison.md says of damaged and killed files is what the tools do."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
OWNERS = Path(os.environ.get("TACTILE_OWNERS") or Path(sys.prefix) / "owners")


@pytest.mark.slow
def test_the_comparison_is_as_the_page_says():
    """The changed picture is handed out by others and not by us; what is killed opens, or not, as the page has it."""
    if not (OWNERS / "lerobot").is_dir():
        pytest.skip(f"could not import lerobot: {OWNERS} is not there; run `make owners`")
    command = [sys.executable, str(ROOT / "benchmarks/comparison.py"), "--owners", str(OWNERS), "--touches", "4"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=900)
    assert done.returncode == 0, done.stderr[-3000:]
    rows = [line.strip("| ").split(" | ") for line in done.stdout.splitlines() if line.startswith("|")][2:]
    flipped, cut, killed, read, size = [
        dict(zip(("tactiledata", "LeRobot", "mcap", "rerun"), row[1:], strict=True)) for row in rows
    ]
    assert "0 changed; says chunk-crc" in flipped["tactiledata"]
    assert "0 changed; says" in cut["tactiledata"]
    assert "1 changed, says nothing" in flipped["mcap"]
    assert "CRCValidationError" in flipped["mcap"]
    assert "`mcap check` says ok" in flipped["rerun"]
    assert "refuses without `--recover`; converts with" in cut["rerun"]
    assert "the store is the same: True" in killed["tactiledata"]
    assert "none of 3 saved episodes opens" in killed["LeRobot"]
    assert re.match(r"1\d{4} of 20000 messages as a stream", killed["mcap"])
    assert killed["rerun"] == "`rrd verify` misses its end; 3 of 3 rows are read"
    assert all("ms" in read[tool] for tool in ("tactiledata", "LeRobot", "mcap"))
    assert all("MB" in cell for cell in size.values())
