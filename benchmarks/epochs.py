"""Epochs over JPEG frames: without a cache, filling one, and reading it, against loose files; values checked equal.

    python benchmarks/epochs.py [--quick] [--frames 400] [--epochs 5] [--workers 2]

Two contests: arrays of uint8 from one process with threads; float32 tensors by PyTorch's `DataLoader`, with workers and
without, where each side is judged with the number of workers that suits it.
Every way sits in a process of its own and they take turns epoch by epoch; the page cache is warm, workers stay from
epoch to epoch. Processor seconds and memory are those of the process and its workers. The targets are judged by
processor seconds, which hardly feel what else the machine does. Without workers, ours reads by as many threads as the
machine has cores.
"""

from __future__ import annotations

import argparse
import os
import statistics
import sys
import tempfile
import time
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from contestants import LooseFiles
from random_access import Frames
from timing import MEGABYTE, Seat, header, median_ratio, table, verdict

BATCH = 64
TARGETS = {"first epoch": 1.2, "later epochs": 3.0}
OTHER = "loose JPEG"


class Epochs:
    """A way that gives epochs of batches; ``batches(order)`` yields (rows, pictures)."""

    def batches(self, order: list[int]) -> Iterator[tuple[Any, Any]]:
        """Batches of an epoch whose frames come in an order."""
        raise NotImplementedError

    def epoch(self, order: list[int]) -> float:
        """Read an epoch and let it go; processor seconds of the process and its workers so far."""
        for _ in self.batches(order):
            pass
        return self.processor_seconds()

    def processor_seconds(self) -> float:
        """Return the processor time of this process and its workers since they began, s."""
        everyone = [psutil.Process(), *psutil.Process().children(recursive=True)]
        # Linux's clock of another process (clock_getcpuclockid): psutil's counts in hundredths of a second
        return sum(time.clock_gettime((~process.pid << 3) | 2) for process in everyone)

    def own(self) -> int:
        """Bytes of anonymous memory of this process and its workers."""
        everyone = [psutil.Process(), *psutil.Process().children(recursive=True)]
        return sum(process.memory_full_info().uss for process in everyone)

    def checksums(self, order: list[int]) -> dict[int, int]:
        """A CRC of the values of every frame, by row."""
        return {
            int(row): zlib.crc32(np.ascontiguousarray(picture))
            for rows, pictures in self.batches(order)
            for row, picture in zip(rows, pictures, strict=True)
        }

    def forget(self) -> None:
        """Before an epoch, untimed."""


class LooseArrays(Epochs):
    """Loose files read by OpenCV from a pool of threads."""

    def __init__(self, folder: Path, threads: int) -> None:
        self._files = LooseFiles(folder / "loose", threads)

    def batches(self, order: list[int]) -> Iterator[tuple[Any, Any]]:
        """Batches of an epoch."""
        return (self._files.batch(order[start : start + BATCH]) for start in range(0, len(order), BATCH))


class LooseTensors(Epochs):
    """What one writes first: a dataset that reads a file an item, and torch's own collate."""

    def __init__(self, folder: Path, workers: int) -> None:
        import torch
        from torch.utils.data import DataLoader

        files, turns = FileDataset(folder / "loose"), Turns()
        torch.set_num_threads(1)
        self._turns = turns
        self._loader = DataLoader(
            files,
            BATCH,
            sampler=turns,
            num_workers=workers,
            persistent_workers=workers > 0,  # type: ignore[arg-type]
        )

    def batches(self, order: list[int]) -> Iterator[tuple[Any, Any]]:
        """Batches of an epoch."""
        self._turns.order = order
        return ((rows, pictures.numpy()) for rows, pictures in self._loader)


class FileDataset:
    """A picture file an item: its number, and (3, H, W) float32 from 0 to 1."""

    def __init__(self, folder: Path) -> None:
        self._files = sorted(str(path) for path in folder.iterdir())

    def __len__(self) -> int:
        return len(self._files)

    def __getitem__(self, row: int) -> tuple[int, Any]:
        import cv2
        import torch

        picture = cv2.imread(self._files[row], cv2.IMREAD_COLOR_RGB)
        return row, torch.from_numpy(picture).permute(2, 0, 1).float().div(255)


class Turns:
    """A sampler that gives what it was told."""

    order: list[int] = []  # noqa: RUF012 - replaced, never changed

    def __iter__(self) -> Iterator[int]:
        return iter(self.order)

    def __len__(self) -> int:
        return len(self.order)


class OurArrays(Epochs):
    """`TactileArrays` without a cache, with one that is emptied before each epoch, or with one that stays."""

    def __init__(self, folder: Path, threads: int, cache: str) -> None:
        from tactiledata.loaders.numpy import TactileArrays

        self._cache = folder / f"cache-arrays-{cache}" if cache else None
        self._is_emptied = cache == "first"
        options: dict[str, Any] = {"cache": self._cache, "threads": threads, "image_dtype": "uint8"}
        self._arrays = TactileArrays(folder / "store", "all", ("digit",), allow_leaks=True, **options)

    def batches(self, order: list[int]) -> Iterator[tuple[Any, Any]]:
        """Batches of an epoch."""
        rows = (order[start : start + BATCH] for start in range(0, len(order), BATCH))
        return ((some, self._arrays.batch(some)["digit"]) for some in rows)

    def forget(self) -> None:
        """Empty the slots of the cache, where each epoch is to be a first one."""
        empty(self._cache if self._is_emptied else None)


class OurTensors(Epochs):
    """`TactileDataset` in a `DataLoader`, with the caches of `OurArrays`."""

    def __init__(self, folder: Path, workers: int, cache: str) -> None:
        import torch
        from torch.utils.data import DataLoader

        from tactiledata.loaders.torch import TactileDataset, collate

        torch.set_num_threads(1)
        self._cache = folder / f"cache-tensors-{workers}-{cache}" if cache else None
        self._is_emptied = cache == "first"
        self._turns = Turns()
        dataset = TactileDataset(folder / "store", "all", ("digit",), cache=self._cache, allow_leaks=True)
        self._loader = DataLoader(
            dataset,
            BATCH,
            sampler=self._turns,  # type: ignore[arg-type]
            num_workers=workers,
            persistent_workers=workers > 0,
            collate_fn=collate,
        )

    def batches(self, order: list[int]) -> Iterator[tuple[Any, Any]]:
        """Batches of an epoch."""
        self._turns.order = order
        return ((batch["frame"], batch["digit"].numpy()) for batch in self._loader)

    def forget(self) -> None:
        """Empty the slots of the cache, where each epoch is to be a first one."""
        empty(self._cache if self._is_emptied else None)


def empty(folder: Path | None) -> None:
    """Make holes of all slots of the caches in a folder; whoever has them open goes on with empty ones."""
    for pixels in folder.glob("*.pixels") if folder else ():
        size = pixels.stat().st_size
        os.truncate(pixels, 0)
        os.truncate(pixels, size)


def contest(
    title: str, ways: dict[str, tuple[Callable[..., Epochs], tuple[Any, ...]]], count: int, epochs: int
) -> bool:
    """Print the table of one contest; whether its targets were met."""
    rng = np.random.default_rng(0)
    orders = [rng.permutation(count).tolist() for _ in range(epochs)]
    seats = {name: Seat(maker, *arguments) for name, (maker, arguments) in ways.items()}
    try:
        _check(seats, orders[0])
        seconds, cpu, own = _timed(seats, orders)
    finally:
        for seat in seats.values():
            seat.close()
    header(title, ["opencv-python-headless", "simplejpeg", "torch", "numpy"])
    other = _best(cpu, OTHER)
    rows = [
        (
            name,
            f"{count / statistics.median(times):,.0f}",
            f"{median_ratio(times, seconds[other]):.2f}",
            f"{median_ratio(cpu[name], cpu[other]):.2f}",
            f"{1e6 * statistics.median(cpu[name]) / count:.0f}",
            f"{own[name][0] / MEGABYTE:.0f}",
            f"{own[name][-1] / MEGABYTE:.0f}",
        )
        for name, times in seconds.items()
    ]
    columns = ["way", "frames/s", "as fast", "by CPU", "CPU us/frame", "own MB, first", "own MB, last"]
    table(columns, rows)
    print(f"values: equal for all ways, decoded and kept; ratios to {other}; load {os.getloadavg()[0]:.0f}")
    met = []
    for kind, target in TARGETS.items():
        ours = _best(cpu, kind)
        met.append(verdict(f"{ours} against {other}, by CPU", median_ratio(cpu[ours], cpu[other]), target))
    return all(met)


def _best(seconds: dict[str, list[float]], word: str) -> str:
    """The way that takes least, of those in whose name a word is."""
    return min((name for name in seconds if word in name), key=lambda name: statistics.median(seconds[name]))


def _check(seats: dict[str, Seat], order: list[int]) -> None:
    """Stop with an error unless all ways give the same values, when first read and when read again."""
    truth = next(seat for name, seat in seats.items() if OTHER in name).call("checksums", order)[-1]
    for name, seat in seats.items():
        for _ in range(2):
            if seat.call("checksums", order)[-1] != truth:
                raise SystemExit(f"{name}: values differ from those of {OTHER}")


def _timed(
    seats: dict[str, Seat], orders: list[list[int]]
) -> tuple[dict[str, list[float]], dict[str, list[float]], dict[str, list[int]]]:
    """Seconds, processor seconds, and bytes of own memory afterwards, of every epoch at every seat."""
    seconds: dict[str, list[float]] = {name: [] for name in seats}
    cpu: dict[str, list[float]] = {name: [] for name in seats}
    own: dict[str, list[int]] = {name: [] for name in seats}
    names = list(seats)
    for number, order in enumerate(orders):
        turn = number % len(names)
        for name in names[turn:] + names[:turn]:
            seat = seats[name]
            seat.call("forget")
            before = seat.call("processor_seconds")[-1]
            wall, _, after = seat.call("epoch", order)
            seconds[name].append(wall)
            cpu[name].append(after - before)
            own[name].append(seat.call("own")[-1])
    return seconds, cpu, own


def main(arguments: list[str] | None = None) -> bool:
    """Run all contests; whether all targets were met."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a run of seconds that only shows that it works")
    parser.add_argument("--frames", type=int, default=400)
    parser.add_argument("--epochs", type=int, default=5)
    parser.add_argument("--workers", type=int, default=2)
    chosen = parser.parse_args(arguments)
    count, epochs = (64, 1) if chosen.quick else (chosen.frames, chosen.epochs)
    if chosen.quick:
        # each worker of a DataLoader imports torch anew
        chosen.workers = 1
    from our_store import write_store

    kinds = {"no cache": "", "first epoch": "first", "later epochs": "later"}
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        frames = Frames("jpeg", count)
        LooseFiles.write(folder / "loose", iter(frames), ".jpg")
        write_store(folder / "store", iter(frames), "jpeg")
        size = f"epochs of {count} JPEG frames of 320 x 240, batches of {BATCH}, median of {epochs}"
        arrays: dict[str, Any] = {
            f"tactiledata, {word}": (OurArrays, (folder, chosen.workers, kind)) for word, kind in kinds.items()
        }
        arrays[OTHER] = (LooseArrays, (folder, chosen.workers))
        tensors: dict[str, Any] = {}
        for workers in (chosen.workers,) if chosen.quick else (0, chosen.workers):
            for word, kind in kinds.items():
                tensors[f"tactiledata, {word}, {workers} workers"] = (OurTensors, (folder, workers, kind))
            tensors[f"{OTHER}, {workers} workers"] = (LooseTensors, (folder, workers))
        contests = [
            contest(f"{size}; uint8 arrays by {chosen.workers} threads", arrays, count, epochs),
            contest(f"{size}; float32 tensors by a DataLoader", tensors, count, epochs),
        ]
    if chosen.quick:
        print("\nquick: this shows that it runs; so few frames measure caches and starting costs, not the ways")
    return all(contests)


if __name__ == "__main__":
    main(sys.argv[1:])
