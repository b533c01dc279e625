"""Progress of plays, counted touch by touch while other processes play them."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

from tactiledata.contract.progress import Progress

INTERVAL = 1.0
"""Seconds between two looks at the files of finished plays."""


class PlayProgress:
    """Reports how many plays are finished: workers keep each in a file of its own, and the files are counted.

    A cache that cannot be written leaves no files; then `finished` alone moves the count, batch by batch.

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
        """Report that at least so many plays are finished, and what they were."""
        with self._lock:
            if count > self._done or what != self._what:
                self._done, self._what = max(count, self._done), what
                self._report(self._done, self._total, what)

    def _watch(self) -> None:
        while not self._stop.wait(self._interval):
            self._missing = [path for path in self._missing if not path.exists()]
            self.finished(self._total - len(self._missing), self._what)
