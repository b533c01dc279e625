"""Frames a second and peak memory of `transfer` against the size of the store: memory stays flat.

    python benchmarks/transfer_speed.py [--recordings 2,8,32] [--methods background_swap,histogram_matching]
        [--model CHECKPOINT]

A recording of the rig's is copied under other titles until there are as many as asked for; each store is transferred in
a process of its own, whose peak memory is told.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from split_models.transfer.methods import LATENT
from split_models.transfer.pixels import PIXEL_TRANSFERS
from tactiledata.ingest.pipeline import ingest
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import load_scenario

PROGRAM = """
import resource, sys, time
from pathlib import Path
from split_models.transfer.transfer_store import transfer_store
from split_models.transfer.methods import transfer_method
from tactiledata.store.read.reader import Store
from tactiledata.store.read.targets import find_target
source, out, name, model = sys.argv[1:]
store, method = Store.open(source), transfer_method(name, Path(model) if model else None)
start = time.perf_counter()
done = transfer_store(store, find_target("ycb-sensorB", store), method, Path(out))
print(done.frames, time.perf_counter() - start, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3)
"""
WORLD = {
    "format": "tactiledata-scenario/1",
    "seed": 5,
    "sensors": {"D20542": {"background": "digit-bg-0"}},
    "indenters": {"ball": {"shape": "sphere"}, "edge": {"shape": "edge"}},
    "streams": {"joints": 125, "tcp": 125, "wrench": 100},
    "generate": {"count": 4, "depth": [0.0005, 0.0008], "shear": [0.0003, 0.0006], "shear_share": 0.6},
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recordings", default="2,8,32")
    parser.add_argument("--methods", default=",".join(PIXEL_TRANSFERS))
    parser.add_argument("--model", default="", help="an image VAE: adds the two latent methods")
    given = parser.parse_args()
    counts = sorted(int(count) for count in given.recordings.split(","))
    names = given.methods.split(",") + (list(LATENT) if given.model else [])
    with tempfile.TemporaryDirectory() as scratch:
        home = Path(scratch)
        stores = {count: build(home / str(count), count) for count in counts}
        print("| method | recordings | frames | frames/s | peak memory, MB |\n|---|---|---|---|---|")
        for name in names:
            for count in counts if name == names[0] else counts[-1:]:
                model = given.model if name in LATENT else ""
                frames, seconds, memory = measure(stores[count], home / f"{name}-{count}.zarr", name, model)
                print(f"| {name} | {count} | {frames:.0f} | {frames / seconds:.0f} | {memory:.0f} |", flush=True)


def build(home: Path, count: int) -> Path:
    """A store of so many recordings."""
    made = record(load_scenario(WORLD), home / "first", "folder")
    for number in range(count):
        log = home / "logs" / f"log-{number}"
        shutil.copytree(made[0], log)
        with (log / "log.yaml").open("a") as stream:
            stream.write(f"\nlicence: number {number}\n")
    ingest([home / "logs"], home / "ds.zarr")
    return home / "ds.zarr"


def measure(store: Path, out: Path, name: str, model: str) -> tuple[float, float, float]:
    """Frames, seconds and peak memory in MB of a transfer in a process of its own."""
    command = [sys.executable, "-c", PROGRAM, str(store), str(out), name, model]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    frames, seconds, memory = map(float, done.stdout.split())
    return frames, seconds, memory


if __name__ == "__main__":
    main()
