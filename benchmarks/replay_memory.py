"""Memory of a replay against the number of trajectories: it stays flat.

    python benchmarks/replay_memory.py [--quick] [--trajectories 1000] [--fidelity linear|finite-strain]

A recording of the rig's is copied under other titles until there are as many trajectories as asked for; each store is
replayed in a process of its own, whose peak memory is told.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tactiledata.ingest.pipeline import ingest
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import load_scenario

EACH = 20
TARGET = 4.0
"""GB."""
PROGRAM = """
import resource, sys
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.replay.attach import replay
from tactiledata.replay.options import ReplayOptions
done = replay(sys.argv[1], ReplayOptions(GelMaterial(0.9e6, 0.47, 0.8), fidelity=sys.argv[2]))
assert done.trajectories, done
print(done.new_frames, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6)
"""
WORLD = {
    "format": "tactiledata-scenario/1",
    "seed": 5,
    "sensors": {"D20542": {"background": "digit-bg-0"}},
    "indenters": {
        "ball": {"shape": "sphere"},
        "dome": {"shape": "dome"},
        "punch": {"shape": "cylinder_flat"},
        "edge": {"shape": "edge"},
    },
    "streams": {"joints": 125, "tcp": 125, "wrench": 100},
    "generate": {"count": EACH, "depth": [0.0005, 0.0008], "shear": [0.0003, 0.0006], "shear_share": 0.6},
}


def main() -> None:
    """Print frames, seconds and peak memory of few and of many trajectories."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="forty trajectories at most")
    parser.add_argument("--trajectories", type=int, default=1000)
    parser.add_argument("--fidelity", default="linear")
    asked = parser.parse_args()
    most = 40 if asked.quick else asked.trajectories
    print(f"## replay, {asked.fidelity}, memory against trajectories")
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        (log,) = record(load_scenario(WORLD), home / "recorded", "folder")
        for count in sorted({EACH, most // 4 // EACH * EACH or EACH, most}):
            logs = []
            for number in range(count // EACH):
                logs.append(home / "logs" / f"log-{number}")
                if not logs[-1].exists():
                    shutil.copytree(log, logs[-1])
                    with (logs[-1] / "log.yaml").open("a") as stream:
                        stream.write(f"\nlicence: number {number}\n")
            store = home / f"{count}.zarr"
            ingest(logs, store)
            began = time.perf_counter()
            command = [sys.executable, "-c", PROGRAM, str(store), asked.fidelity]
            done = subprocess.run(command, capture_output=True, text=True, check=True)
            frames, peak = done.stdout.split()
            spent = time.perf_counter() - began
            verdict = "met" if float(peak) < TARGET else "missed"
            speed = f"{spent:6.0f} s, {1e3 * spent / int(frames):5.1f} ms a frame"
            memory = f"peak {float(peak):.2f} GB (target {TARGET:g} GB: {verdict})"
            print(f"{count:5d} trajectories, {frames:>6} frames: {speed}, {memory}", flush=True)
            shutil.rmtree(store)


if __name__ == "__main__":
    main()
