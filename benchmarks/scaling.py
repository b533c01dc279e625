"""What a data set takes in time, disk and memory, worked out from rates that are measured here, and what breaks first.

    python benchmarks/scaling.py [--count 24] [--cores 2 16 1000] [--write docs/scaling.md]

A small world of the rig is recorded, ingested, split, replayed, transferred and read. Seconds are those of processors,
so that other work on the machine hardly counts. What grows with the frames is multiplied; work that one process does
for all of them (commits, splits) is not divided by the number of cores. The sizes are those of the paper, 1,000,000
frames in 65,000 trajectories, and 1,000 times that. Memory is that of the tables that a process reads whole.
"""

from __future__ import annotations

import argparse
import datetime
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scale_splits import write_index
from timing import table

from split_models.transfer.methods import transfer_method
from split_models.transfer.transfer_store import transfer_store
from tactiledata.contract.atomic import write_atomic
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.ingest import pipeline
from tactiledata.replay.attach import replay
from tactiledata.replay.options import ReplayOptions
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.rig.scenario.worlds import find_scenario
from tactiledata.splits.audit import audit
from tactiledata.splits.make import make_split
from tactiledata.store.read.reader import Store
from tactiledata.store.read.targets import find_target

FRAMES, TRAJECTORIES = 1_000_000, 65_000
"""Frames and trajectories of the paper's data set."""
PER_RECORDING = find_scenario("paper")["recordings"]["trajectories_per_log"]
"""Trajectories of a recording in the paper's protocol, as the bundled world has it."""
MEMORY = 16e9
"""Bytes of memory of one machine; the largest data set that fits is told."""
START, STOP = "<!-- printed -->\n", "<!-- end of printed -->\n"


@dataclass(frozen=True)
class Rate:
    """What one step costs a frame.

    Parameters
    ----------
    step : str
    parallel, serial : float
        Seconds of a processor for a frame: of workers, and of the one process that writes.
    disk : float
        Bytes that it adds for a frame.
    """

    step: str
    parallel: float
    serial: float
    disk: float

    def hours(self, frames: float, cores: int) -> float:
        """Hours of a number of frames on a number of cores."""
        return frames * (self.parallel / cores + self.serial) / 3600


def spent(call: Callable[[], Any]) -> tuple[float, Any]:
    """Processor seconds of a call, and what it returned."""
    start = time.process_time()
    value = call()
    return time.process_time() - start, value


def size_of(place: Path) -> int:
    """Bytes on disk below a folder; holes in files take none."""
    return sum(512 * path.stat().st_blocks for path in place.rglob("*") if path.is_file())


def measured(folder: Path, count: int) -> tuple[list[Rate], dict[str, float]]:
    """Rates of all steps, and bytes of memory and of the manifest for each frame, recording or trajectory."""
    # a world as small as it can be, with as many touches as are asked for
    world = dict(find_scenario("tiny"))
    world["generate"] = {**world["generate"], "count": count}
    logs = record(load_scenario(world), folder / "logs", "mcap")
    place = folder / "ds.zarr"
    # reading is done by workers, the rest by one process
    reading, read = 0.0, pipeline._read_source

    def timed_read(task: Any) -> Any:
        nonlocal reading
        seconds, value = spent(lambda: read(task))
        reading += seconds
        return value

    pipeline._read_source = timed_read
    try:
        ingesting, _ = spent(lambda: pipeline.ingest(logs, place))
    finally:
        pipeline._read_source = read
    store = Store.open(place)
    frames = store.n_frames
    size = size_of(place)
    rates = [
        Rate("record (the logs alone)", 0.0, 0.0, sum(path.stat().st_size for path in logs) / frames),
        Rate("ingest", reading / frames, (ingesting - reading) / frames, size / frames),
    ]
    # index of a twentieth of the paper, for what one process does with all tables
    index = folder / "index.zarr"
    write_index(index, TRAJECTORIES // 20, FRAMES // 20)
    splitting = spent(lambda: make_split(Store.open(index), by=("trajectory", "sensor")))[0]
    auditing = spent(lambda: audit(Store.open(index), images=False))[0]
    rates.append(Rate("split, audit without pictures", 0.0, (splitting + auditing) / (FRAMES // 20), 0.0))
    # meshes: the first replay condenses the pad, which counts once and not for each frame
    for fidelity in ("linear", "finite-strain"):
        options = ReplayOptions(material=GelMaterial(0.9e6, 0.47, 0.7), fidelity=fidelity, name=fidelity)
        replay(place, ReplayOptions(**{**vars(options), "name": f"first-{fidelity}"}))
        before = size_of(place)
        seconds, _ = spent(lambda options=options: replay(place, options))
        rates.append(Rate(f"replay, {fidelity}", seconds / frames, 0.0, (size_of(place) - before) / frames))
    for name in ("relit", "latent-relit"):
        out = folder / f"{name}.zarr"
        method, target = transfer_method(name), find_target("ycb-sensorA", store)
        seconds, made = spent(lambda method=method, out=out, target=target: transfer_store(store, target, method, out))
        rates.append(Rate(f"transfer, {name}", seconds / made.frames, 0.0, size_of(out) / made.frames))
    seconds, _ = spent(lambda: [store.images(range(start, min(start + 64, frames))) for start in range(0, frames, 64)])
    rates.append(Rate("read all pictures once", seconds / frames, 0.0, 0.0))
    # memory
    big = Store.open(index)
    facts = {
        "tables": (big.frames().nbytes + big.trajectories().nbytes) / big.n_frames,
        "manifest": (index / "manifest.json").stat().st_size / 1.0,
        "recording": len(",".join(store.manifest["sources"])) / len(store.manifest["sources"]) + 3,
    }
    return rates, facts


def told(rates: list[Rate], facts: dict[str, float], cores: list[int]) -> None:
    """Print the rates, and what the two sizes take."""
    print("## rates, one processor")
    table(
        ("step", "workers, ms a frame", "one process, ms a frame", "disk, kB a frame"),
        [
            (rate.step, f"{1e3 * rate.parallel:.2f}", f"{1e3 * rate.serial:.3f}", f"{rate.disk / 1e3:.1f}")
            for rate in rates
        ],
    )
    for factor in (1, 1000):
        frames = FRAMES * factor
        print(f"\n## {frames:,} frames, {TRAJECTORIES * factor:,} trajectories")
        table(
            ("step", *(f"hours, {count} cores" for count in cores), "disk, GB"),
            [
                (
                    rate.step,
                    *(f"{rate.hours(frames, count):,.3g}" for count in cores),
                    f"{rate.disk * frames / 1e9:,.4g}",
                )
                for rate in rates
            ],
        )
        recordings = TRAJECTORIES * factor / PER_RECORDING
        print(f"tables in memory: {facts['tables'] * frames / 1e9:,.2f} GB")
        print(f"names of {recordings:,.0f} recordings in the manifest: {facts['recording'] * recordings / 1e6:,.3f} MB")
    print("\n## what breaks first, as the data grow")
    limits = [
        (MEMORY / facts["tables"], f"tables of frames and trajectories fill {MEMORY / 1e9:.0f} GB of one process"),
        *(
            (24 * 3600 / rate.serial, f"{rate.step}: the one process that writes takes a day")
            for rate in rates
            if rate.serial
        ),
    ]
    table(("frames", "times the paper", "what happens"), [
        (f"{frames:,.3g}", f"{frames / FRAMES:,.3g}", what) for frames, what in sorted(limits)
    ])  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=24, help="touches that are recorded")
    parser.add_argument("--cores", type=int, nargs="*", default=[2, 16, 1000])
    parser.add_argument("--write", type=Path, help="page that takes the output between its marks")
    given = parser.parse_args()
    if given.write:
        words = [part for part in ("--count", str(given.count)) if given.count != 24]
        done = subprocess.run([sys.executable, __file__, *words], check=True, capture_output=True, text=True).stdout
        commit = subprocess.run(["git", "rev-parse", "--short=8", "HEAD"], check=True, capture_output=True, text=True)
        said = (
            f"`python benchmarks/scaling.py` at {commit.stdout.strip()}, {datetime.date.today():%d %B %Y}, simulated "
            f"touches on real DIGIT backgrounds:\n\n```text\n{done}```\n"
        )
        head, _, rest = given.write.read_text(encoding="utf-8").partition(START)
        write_atomic(given.write, f"{head}{START}{said}{STOP}{rest.partition(STOP)[2]}".encode())
        return
    with tempfile.TemporaryDirectory() as folder:
        rates, facts = measured(Path(folder), given.count)
    told(rates, facts, given.cores)


if __name__ == "__main__":
    main()
