"""Every benchmark after the other: `make bench`. Each also runs alone; `--quick` shows in minutes that they work."""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

BENCHMARKS = (
    "random_access.py",
    "epochs.py",
    "ingest_mcap.py",
    "scale_splits.py",
    "gel_speed.py",
    "gel_growth.py",
    "gel_mesh_error.py",
    "linear_error.py",
    "estimated_plays.py",
    "plays_growth.py",
    "solver_difference.py",
    "replay_memory.py",
    "calibration_worlds.py",
    "naming_worlds.py",
    "locating_worlds.py",
    "diagnose_speed.py",
    "inference.py",
)


def main() -> int:
    """Run them; 1 where one failed to run. A missed target is printed and is no failure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    options = ["--quick"] if parser.parse_args().quick else []
    folder = Path(__file__).resolve().parent
    codes = [subprocess.run([sys.executable, folder / name, *options], check=False).returncode for name in BENCHMARKS]
    return int(any(codes))


if __name__ == "__main__":
    sys.exit(main())
