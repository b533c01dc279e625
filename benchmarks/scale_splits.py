"""Split and audit of a store at the paper's size: 65,000 trajectories and 1,000,000 frames, without image hashes.

    python benchmarks/scale_splits.py [--quick] [--trajectories 65000] [--frames 1000000]

The store on disk is an index only: the tables that a real one of this size has, in parts of 50,000 frames, and no
images. Every step reads the index from disk again, as the command does.
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from tactiledata.contract.take import FRAME_SCHEMA, SOURCE_SCHEMA, TRAJECTORY_SCHEMA
from tactiledata.splits.audit import audit
from tactiledata.splits.make import make_split
from tactiledata.splits.manifest import frame_rows, load_split
from tactiledata.splits.options import PARTITIONS
from tactiledata.store.layout.batch import Batch
from tactiledata.store.layout.manifest import write_manifest
from tactiledata.store.read.reader import Store
from tactiledata.store.write.appender import write_part
from tactiledata.store.write.commit import create

SECONDS, BYTES = 20.0, 2e9
PER_SOURCE = 100
PART = 50_000
START_NS = 1_700_000_000_000_000_000
SENSORS = np.array([f"D{20540 + k}" for k in range(5)])
INDENTERS = np.array([f"indenter{k:02d}" for k in range(13)])


def sources(n_trajectories: int, n_frames: int) -> pa.Table:
    """A sources table: `PER_SOURCE` trajectories each."""
    n = -(-n_trajectories // PER_SOURCE)
    made: dict[str, Any] = {
        "sha256": [f"{k:064x}" for k in range(n)],
        "key": [f"day{k // 50}/run{k}.mcap" for k in range(n)],
        "format": ["mcap"] * n,
        "frames": [n_frames // n] * n,
        "trajectories": [PER_SOURCE] * n,
        "status": ["ok"] * n,
        **{name: ["{}"] * n for name in ("description", "provenance", "contents")},
    }
    return pa.table([pa.array(made[field.name], field.type) for field in SOURCE_SCHEMA], schema=SOURCE_SCHEMA)


def trajectories(n: int, frames_each: np.ndarray) -> pa.Table:
    """A trajectories table: one in twenty is derived from an earlier one of its source, and the last tenth of the
    recordings are copies of the first.
    """
    rows = np.arange(n)
    rng = np.random.default_rng(0)
    uids = np.array([f"{(0x9E3779B97F4A7C15 * (k + 1)) % 2**64:016x}" for k in range(n)])
    parent = np.where((rows % 20 == 19), uids[np.maximum(rows - 7, 0)], "")
    stops = np.cumsum(frames_each)
    first_copy = 9 * n // (10 * PER_SOURCE) * PER_SOURCE
    moment = np.where(rows < first_copy, rows, rows - first_copy)
    start_ns = START_NS + moment * 10**10
    made: dict[str, Any] = {
        "uid": uids,
        "trajectory": np.char.add("press ", rows.astype(str)),
        "source": rows // PER_SOURCE,
        "sensor": SENSORS[rng.integers(0, len(SENSORS), n)[moment]],
        "indenter": INDENTERS[rng.integers(0, len(INDENTERS), n)],
        "start_ns": start_ns,
        "end_ns": start_ns + 5 * 10**9,
        "frame_start": stops - frames_each,
        "frame_stop": stops,
        "signal_rows": ["{}"] * n,
        "peak_force": rng.uniform(1, 13, n),
        "segmented": ["log"] * n,
        "parent": parent,
        "extra": ["{}"] * n,
    }
    return pa.table([pa.array(made[f.name]).cast(f.type) for f in TRAJECTORY_SCHEMA], schema=TRAJECTORY_SCHEMA)


def frames(index: pa.Table, frames_each: np.ndarray) -> pa.Table:
    """A frames table; frames of derived trajectories name a frame of their parent's."""
    n = int(frames_each.sum())
    rng = np.random.default_rng(1)
    owner = np.repeat(np.arange(index.num_rows), frames_each)
    starts = index["frame_start"].to_numpy()
    derived = (owner % 20 == 19) & (owner >= 7)
    words = {"camera": "digit", "encoding": "jpeg"}
    made: dict[str, Any] = {
        **{name: pa.DictionaryArray.from_arrays(np.zeros(n, np.int32), [word]) for name, word in words.items()},
        "trajectory": owner,
        "source": owner // PER_SOURCE,
        "sensor": index["sensor"].combine_chunks().take(pa.array(owner)).dictionary_encode(),
        **{name: np.arange(n) * 10**7 for name in ("t_ns", "log_ns", "publish_ns", "header_ns", "offset")},
        "height": np.full(n, 320),
        "width": np.full(n, 240),
        "length": rng.integers(14_000, 21_000, n),
        "crc32c": rng.integers(0, 2**32, n),
        "contact_force": rng.uniform(0, 14, n),
        "flags": np.zeros(n, int),
        "parent_frame": np.where(derived, starts[np.maximum(owner - 7, 0)], -1),
    }
    return pa.table([pa.array(made[f.name]).cast(f.type) for f in FRAME_SCHEMA], schema=FRAME_SCHEMA)


def write_index(folder: Path, n_trajectories: int, n_frames: int) -> None:
    """A store that has an index and nothing else."""
    manifest = create(folder)
    each = np.full(n_trajectories, n_frames // n_trajectories)
    each[: n_frames - int(each.sum())] += 1
    index = trajectories(n_trajectories, each)
    tables = {"sources": sources(n_trajectories, n_frames), "trajectories": index, "frames": frames(index, each)}
    with Batch(folder) as batch:
        for name, table in tables.items():
            parts = manifest["index"][name]
            for start in range(0, table.num_rows, PART):
                parts.append(write_part(batch, name, f"part-{len(parts):05d}.parquet", table.slice(start, PART)))
            manifest["rows"][name] = table.num_rows
        batch.publish()
    write_manifest(folder, manifest)


def timed(what: str, call: Any) -> tuple[float, Any]:
    """Seconds of a call, printed, and what it returned."""
    start = time.perf_counter()
    value = call()
    seconds = time.perf_counter() - start
    print(f"{what:<32}{seconds:8.2f} s")
    return seconds, value


def main() -> int:
    """Print time and peak memory; 0 whatever they are, 1 where the audit finds a leak that was not planted."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a hundredth of the size")
    parser.add_argument("--trajectories", type=int, default=65_000)
    parser.add_argument("--frames", type=int, default=1_000_000)
    options = parser.parse_args()
    n_trajectories, n_frames = options.trajectories, options.frames
    if options.quick:
        n_trajectories, n_frames = n_trajectories // 100, n_frames // 100
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "ds.zarr"
        # another process builds it, so that the peak below is that of splitting
        builder = multiprocessing.get_context("spawn").Process(
            target=write_index, args=(folder, n_trajectories, n_frames)
        )
        builder.start()
        builder.join()
        if builder.exitcode:
            return 1
        units = f"{len(SENSORS)} sensors, {len(INDENTERS)} indenters"
        print(f"index of {n_trajectories} trajectories, {n_frames} frames, {units}")
        by = ("trajectory", "sensor", "indenter")
        first, _ = timed("split", lambda: make_split(Store.open(folder), by=by))
        second, report = timed("audit without images", lambda: audit(Store.open(folder), images=False))
        store = Store.open(folder)
        _, split = timed("load the split", lambda: load_split(store, "default"))
        _, rows = timed(
            "frames of the four parts", lambda: [len(frame_rows(store, split, part)) for part in PARTITIONS]
        )
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    print(f"frames in parts: {dict(zip(PARTITIONS, rows, strict=True))}")
    print(f"split and audit: {first + second:.1f} s (target {SECONDS:.0f} s: {verdict(first + second < SECONDS)})")
    print(f"peak memory: {peak / 1e9:.2f} GB (target {BYTES / 1e9:.0f} GB: {verdict(peak < BYTES)})")
    print("\n".join(report.lines()))
    return int(bool(report.leaks))


def verdict(is_met: bool) -> str:
    """The word for a target."""
    return "met" if is_met else "MISSED"


if __name__ == "__main__":
    sys.exit(main())
