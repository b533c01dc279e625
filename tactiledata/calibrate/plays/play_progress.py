"""Progress of simulations in other processes, from the files that they have finished."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

from tactiledata.contract.progress import Progress

INTERVAL = 1.0
"""Seconds between two counts of the finished files."""
ROUNDING = 1e-6
"""What a sum of lengths may fall short of a whole number of plays."""


class PlayProgress:
    """Report of how many simulated touches are finished, by their files in the cache.

    Plays that take longer count for more, so that the time that is left can be told from the count: it is the number of
    plays of mean length that would take as long as what is finished. A cache that cannot be written leaves no files;
    then only `finished` raises the count, batch by batch.

    Parameters
    ----------
    paths : sequence of Path
        Where the plays are kept, one for each play that is asked for.
    report : callable
        Called with how many plays are finished, how many there are, and what was played last.
    efforts : sequence of float, optional
        About how long each play takes, in any unit; all as long where ``None``.
    interval : float
        Seconds between two counts.
    """

    def __init__(
        self,
        paths: Sequence[Path],
        report: Progress,
        efforts: Sequence[float] | None = None,
        interval: float = INTERVAL,
    ) -> None:
        self._total = len(paths)
        # in plays of mean length
        mean = sum(efforts or ()) / max(len(paths), 1)
        lengths = [effort / mean for effort in efforts] if efforts and mean > 0.0 else [1.0] * len(paths)
        self._missing = list(zip(paths, lengths, strict=True))
        self._lengths_up_to = list(itertools.accumulate(lengths, initial=0.0))
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
        """Report that at least the first ``count`` plays are finished; ``what`` is a label of the last ones."""
        self._tell(self._lengths_up_to[count], what)

    def _tell(self, length: float, what: str) -> None:
        """Report that at least plays of a length are finished, in plays of mean length."""
        done = int(length + ROUNDING)
        with self._lock:
            if done > self._done or what != self._what:
                self._done, self._what = max(done, self._done), what
                self._report(self._done, self._total, what)

    def _watch(self) -> None:
        """Look for finished files at each interval, until the work ends."""
        while not self._stop.wait(self._interval):
            self._missing = [(path, length) for path, length in self._missing if not path.exists()]
            self._tell(self._total - sum(length for _, length in self._missing), self._what)
