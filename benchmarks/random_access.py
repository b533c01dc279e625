"""Random-access loading in batches of 64: our loader against the usual ways, on the same frames, pixels checked equal.

    python benchmarks/random_access.py [--quick] [--frames 2000] [--batches 24]

Every way sits in a process of its own and they take turns batch by batch; the page cache is warm. "own" memory is the
peak of anonymous memory above the start, "mapped" that of file pages, which the system takes back when it needs them.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
import zlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from contestants import (
    Contestant,
    Hdf5Bytes,
    Hdf5Chunked,
    LooseFiles,
    Pixels,
    WebDatasetShards,
    ZarrPlain,
    decode,
    folder_bytes,
)
from digit_frames import digit_frames, encoded
from our_loader import OurLoader
from timing import MEGABYTE, Seat, header, interleaved, median_ratio, table, verdict

BATCH = 64
THREADS = (2, 1)
"""Threads where a way has a pool: ours, loose files and HDF5 with bytes get the same numbers."""

WARM_UP = 2
SEQUENTIAL = "WebDataset (sequential, shuffle buffer)"
TARGETS = {"jpeg": 1.0, "lossless": 1.2}


class Frames:
    """The frames of a contest, drawn and encoded once: encoded bytes and the pixels that must be read."""

    def __init__(self, kind: str, count: int) -> None:
        extension = ".jpg" if kind == "jpeg" else ".png"
        self._payloads = [encoded(picture, extension) for picture in digit_frames(count)]

    def __iter__(self) -> Iterator[tuple[bytes, Pixels]]:
        return ((payload, decode(payload)) for payload in self._payloads)


def build(
    kind: str, folder: Path, frames: Frames, count: int, pools: Sequence[int]
) -> dict[str, tuple[Path, Callable[..., Contestant], tuple[Any, ...]]]:
    """All ways, written: name -> (folder, maker, its arguments)."""
    from our_store import write_store

    extension, word = (".jpg", "JPEG") if kind == "jpeg" else (".png", "PNG")
    loose, chunked, entries, plain, shards = (folder / name for name in ("loose", "h5", "h5bytes", "zarr", "wds"))
    LooseFiles.write(loose, iter(frames), extension)
    Hdf5Chunked.write(chunked, iter(frames), count)
    Hdf5Bytes.write(entries, iter(frames), count)
    ZarrPlain.write(plain, iter(frames), count)
    WebDatasetShards.write(shards, iter(frames), extension)
    ours = {"jpeg": ["jpeg"], "lossless": ["raw", "png"]}[kind]
    ways: dict[str, tuple[Path, Callable[..., Contestant], tuple[Any, ...]]] = {}
    for encoding in ours:
        store = folder / f"ours-{encoding}"
        write_store(store, iter(frames), encoding)
        for threads in pools:
            ways[f"tactiledata ({encoding}), {_threads(threads)}"] = (store, OurLoader, (store, threads))
    for threads in pools:
        ways[f"loose {word} + OpenCV, {_threads(threads)}"] = (loose, LooseFiles, (loose, threads))
        ways[f"HDF5 with {word} bytes, {_threads(threads)}"] = (entries, Hdf5Bytes, (entries, threads))
    ways["HDF5 chunked by frame, gzip, loop"] = (chunked, Hdf5Chunked, (chunked,))
    ways["plain zarr-python, chunk a frame, zstd, loop"] = (plain, ZarrPlain, (plain,))
    ways[SEQUENTIAL] = (shards, WebDatasetShards, (shards,))
    return ways


def _threads(threads: int) -> str:
    return f"{threads} threads" if threads > 1 else "1 thread"


def check_pixels(frames: Frames, seats: dict[str, Seat], batches: list[list[int]]) -> None:
    """Nothing, where every way gives the true pixels of every frame that it reads."""
    truth = {row: zlib.crc32(np.ascontiguousarray(pixels)) for row, (_, pixels) in enumerate(frames)}
    for name, seat in seats.items():
        wrong = [row for row, crc in seat.call("checksums", batches)[-1].items() if truth[row] != crc]
        if wrong:
            raise SystemExit(f"{name}: the pixels of {len(wrong)} frames differ, first of row {wrong[0]}")


def contest(kind: str, count: int, n_batches: int, pools: Sequence[int] = THREADS) -> bool:
    """Print the table for one kind of frames; whether the target was met."""
    rng = np.random.default_rng(0)
    batches = [rng.choice(count, min(BATCH, count), replace=False).tolist() for _ in range(n_batches + WARM_UP)]
    with tempfile.TemporaryDirectory() as scratch:
        frames = Frames(kind, count)
        ways = build(kind, Path(scratch), frames, count, pools)
        seats = {name: Seat(maker, *arguments) for name, (_, maker, arguments) in ways.items()}
        try:
            check_pixels(frames, seats, batches[:WARM_UP])
            seconds, cpu_seconds = interleaved(seats, [("read", (rows,)) for rows in batches[WARM_UP:]])
            memory = {name: seat.memory("read", batches[0]) for name, seat in seats.items()}
        finally:
            for seat in seats.values():
                seat.close()
        sizes = {name: folder_bytes(folder) / count for name, (folder, _, _) in ways.items()}
    return _show(kind, count, len(batches[0]), seconds, cpu_seconds, memory, sizes)


def _show(
    kind: str,
    count: int,
    batch: int,
    seconds: dict[str, list[float]],
    cpu_seconds: dict[str, list[float]],
    memory: dict[str, dict[str, float]],
    sizes: dict[str, float],
) -> bool:
    n_batches = len(next(iter(seconds.values())))
    header(
        f"random access, {kind}: {count} frames of 320 x 240, batches of {batch}, median of {n_batches}",
        ["opencv-python-headless", "h5py", "zarr", "webdataset", "numpy"],
    )
    ours = next(name for name in seconds if name.startswith("tactiledata"))
    rows = [
        (
            name,
            f"{batch / statistics.median(times):,.0f}",
            f"{median_ratio(seconds[ours], times):.2f}",
            f"{1e6 * statistics.median(cpu_seconds[name]) / batch:.0f}",
            f"{sizes[name]:,.0f}",
            f"{memory[name]['own'] / MEGABYTE:.0f}",
            f"{memory[name]['mapped'] / MEGABYTE:.0f}",
        )
        for name, times in seconds.items()
    ]
    table(["way", "frames/s", "time / ours", "CPU us/frame", "bytes/frame", "own MB", "mapped MB"], rows)
    print("pixels: equal for all ways")
    others = [name for name in seconds if not name.startswith("tactiledata")]
    ratios = {name: median_ratio(seconds[ours], seconds[name]) for name in others}
    best = min(ratios, key=lambda name: ratios[name])
    return verdict(f"ours against the best other ({best})", ratios[best], TARGETS[kind])


def main(arguments: list[str] | None = None) -> bool:
    """Run both contests; whether both targets were met."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a run of seconds that only shows that it works")
    parser.add_argument("--frames", type=int, default=2000)
    parser.add_argument("--batches", type=int, default=24)
    chosen = parser.parse_args(arguments)
    size = (32, 1, THREADS[:1]) if chosen.quick else (chosen.frames, chosen.batches, THREADS)
    met = [contest(kind, *size) for kind in TARGETS]
    if chosen.quick:
        print("\nquick: this shows that it runs; so few frames measure caches and starting costs, not the ways")
    return all(met)


if __name__ == "__main__":
    main(sys.argv[1:])
