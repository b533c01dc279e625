"""Progress of simulations in other processes, from the files that they have finished."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

from tactiledata.contract.progress import Progress

INTERVAL = 1.0
"""Seconds between two counts of the finished files."""


class PlayProgress:
    """Report of how many simulated touches are finished, counted by their files in the cache.

    A cache that cannot be written leaves no files; then only `finished` raises the count, batch by batch.

    Parameters
    ----------
    paths : sequence of Path
        Where the plays are kept, one for each play that is asked for.
    report : callable
        Called with how many plays are finished, how many there are, and what was played last.
    interval : float
        Seconds between two counts.
    """

    def __init__(self, paths: Sequence[Path], report: Progress, interval: float = INTERVAL) -> None:
        self._missing, self._total = list(paths), len(paths)
        self._report, self._interval = report, interval
        self._done, self._what = 0, ""
        self._lock, self._stop = threading.Lock(), threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> PlayProgress:
        self._report(0, self._total)
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        self._thread.join()

    def finished(self, count: int, what: str) -> None:
        """Report that at least ``count`` plays are finished; ``what`` is a label of the last ones."""
        with self._lock:
            if count > self._done or what != self._what:
                self._done, self._what = max(count, self._done), what
                self._report(self._done, self._total, what)

    def _watch(self) -> None:
        """Count the finished files at each interval, until the work ends."""
        while not self._stop.wait(self._interval):
            self._missing = [path for path in self._missing if not path.exists()]
            self.finished(self._total - len(self._missing), self._what)
