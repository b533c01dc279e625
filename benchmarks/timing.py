"""Fair timing: every contestant in a process of its own, repeats interleaved, medians; and tables that show them."""

from __future__ import annotations

import importlib.metadata
import multiprocessing
import os
import platform
import statistics
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import psutil

MEGABYTE = 1e6
START_LIMIT_S = 600.0
CALL_LIMIT_S = 3600.0


class Seat:
    """A contestant in its own process: what it does is timed there, and its memory is its own.

    Parameters
    ----------
    build : callable
        Makes the contestant inside the process; its module is imported there anew.
    *arguments
        What ``build`` is called with.
    """

    def __init__(self, build: Callable[..., Any], *arguments: Any) -> None:
        context = multiprocessing.get_context("spawn")
        self._ours, theirs = context.Pipe()
        self._process = context.Process(target=_sit, args=(theirs, build, arguments), daemon=False)
        self._process.start()
        theirs.close()
        self._answer(START_LIMIT_S)

    def call(self, method: str, *arguments: Any) -> tuple[float, float, Any]:
        """Seconds, and processor seconds of all threads, that a method took in the process; and what it returned."""
        self._ours.send((method, arguments))
        return self._answer(CALL_LIMIT_S)

    def memory(self, method: str, *arguments: Any) -> dict[str, float]:
        """Peak growth in bytes while a method runs, untimed: ``own`` (anonymous) and ``mapped`` (pages of files).

        Measured from the moment at which the contestant was built.
        """
        self._ours.send(("watched", (method, *arguments)))
        return self._answer(CALL_LIMIT_S)[-1]

    def _answer(self, limit: float) -> Any:
        if not self._ours.poll(limit):
            self._process.terminate()
            raise TimeoutError(f"a contestant did not answer within {limit:.0f} s")
        outcome, value = self._ours.recv()
        if outcome == "error":
            # its process would wait for calls that never come, and ours for its end
            self.close()
            raise RuntimeError(f"a contestant failed: {value}")
        return value

    def close(self) -> None:
        """End the process."""
        self._ours.close()
        self._process.join()


class _Watched:
    """A contestant, and the peaks of this process's memory, looked at every 2 ms while `watched` runs."""

    def __init__(self, contestant: Any) -> None:
        self._contestant = contestant
        self._process = psutil.Process()
        self._start = self._look()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._contestant, name)

    def _look(self) -> tuple[int, int]:
        memory = self._process.memory_info()
        return memory.rss - memory.shared, memory.shared

    def watched(self, method: str, *arguments: Any) -> dict[str, float]:
        """Peak growth while a method of the contestant runs."""
        peaks, done = [self._look()], threading.Event()

        def look() -> None:
            while not done.wait(0.002):
                peaks.append(self._look())

        watcher = threading.Thread(target=look)
        watcher.start()
        getattr(self._contestant, method)(*arguments)
        done.set()
        watcher.join()
        own, mapped = (max(values) - start for values, start in zip(zip(*peaks, strict=True), self._start, strict=True))
        return {"own": own, "mapped": mapped}


def _sit(pipe: Any, build: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    try:
        contestant = _Watched(build(*arguments))
        pipe.send(("ok", None))
    except Exception as error:  # noqa: BLE001 - whatever it is, the parent must hear of it
        pipe.send(("error", repr(error)))
        return
    while True:
        try:
            method, call_arguments = pipe.recv()
        except EOFError:
            return
        try:
            started, cpu_started = time.perf_counter(), time.process_time()
            result = getattr(contestant, method)(*call_arguments)
            pipe.send(("ok", (time.perf_counter() - started, time.process_time() - cpu_started, result)))
        except Exception as error:  # noqa: BLE001 - as above
            pipe.send(("error", repr(error)))


def interleaved(
    seats: Mapping[str, Seat], calls: Sequence[tuple[str, tuple[Any, ...]]]
) -> tuple[dict[str, list[float]], dict[str, list[float]]]:
    """Seconds and processor seconds of every call at every seat; the seats take turns, and who begins rotates.

    So whatever else the machine does meanwhile falls on all contestants alike; processor seconds hardly feel it.
    """
    seconds: dict[str, list[float]] = {name: [] for name in seats}
    cpu_seconds: dict[str, list[float]] = {name: [] for name in seats}
    names = list(seats)
    for number, (method, arguments) in enumerate(calls):
        turn = number % len(names)
        for name in names[turn:] + names[:turn]:
            wall, cpu, _ = seats[name].call(method, *arguments)
            seconds[name].append(wall)
            cpu_seconds[name].append(cpu)
    return seconds, cpu_seconds


def median_ratio(ours: Sequence[float], other: Sequence[float]) -> float:
    """Median over the repeats of ``other / ours``, repeat by repeat: above 1 means that ours is faster."""
    return statistics.median(second / first for first, second in zip(ours, other, strict=True))


def header(title: str, packages: Sequence[str]) -> None:
    """Print what was measured on: cores, Python, versions; nothing that names the machine."""
    versions = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in packages)
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    memory = psutil.virtual_memory().total / 1e9
    print(f"\n## {title}")
    print(f"{cores} cores, {memory:.0f} GB, {platform.machine()}, Python {platform.python_version()}; {versions}")


def table(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Print rows under columns; numbers to the right."""
    texts = [[str(cell) for cell in row] for row in rows]
    widths = [max(len(column), *(len(row[place]) for row in texts)) for place, column in enumerate(columns)]
    print("  ".join(column.ljust(width) for column, width in zip(columns, widths, strict=True)))
    print("  ".join("-" * width for width in widths))
    for row in texts:
        cells = [
            cell.ljust(width) if place == 0 else cell.rjust(width)
            for place, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        print("  ".join(cells))


def verdict(what: str, ratio: float, target: float, *, at_most: bool = False) -> bool:
    """Print whether a ratio meets its target, and return it."""
    met = ratio <= target if at_most else ratio >= target
    bound = "at most" if at_most else "at least"
    print(f"{what}: {ratio:.2f} (target: {bound} {target:.1f}) {'met' if met else 'MISSED'}")
    return met
