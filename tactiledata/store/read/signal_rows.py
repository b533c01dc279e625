"""Signals of a store at their native rate, and what columns of numbers mean."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactiledata.store.layout.places import signal_path
from tactiledata.store.read.recorded import RecordedNumbers


@dataclass(frozen=True)
class Meaning:
    """What columns of numbers mean.

    Parameters
    ----------
    columns, units : tuple of str
    frame : str
        The frame in which vectors are expressed, as the recording names it.
    attributes : dict
        Of the first recording that brought them; ``sources()`` has each recording's own in ``contents``.
    statistics : dict
        ``count``, ``mean``, ``m2``, ``min``, ``max`` of each column, over all finite values of the store.
    """

    columns: tuple[str, ...]
    units: tuple[str, ...]
    frame: str
    attributes: Mapping[str, Any]
    statistics: Mapping[str, Any]

    @classmethod
    def of(cls, facts: Mapping[str, Any]) -> Meaning:
        """Read the meaning of a signal from an entry of the manifest."""
        columns, units = tuple(facts["columns"]), tuple(facts["units"])
        return cls(columns, units, facts["frame"], facts["attributes"], facts["statistics"])


class SignalRows:
    """A signal at its native rate; ``signal_rows`` of a trajectory are ranges of its rows."""

    def __init__(self, recorded: RecordedNumbers, home: str, name: str, facts: Mapping[str, Any]) -> None:
        self.name = name
        self.meaning = Meaning.of(facts)
        self.n_rows: int = facts["rows"]
        arrays = ("t_ns", "value", "log_ns", "publish_ns", "header_ns")
        self._rows = {array: recorded.rows(signal_path(home, name, array), self.n_rows) for array in arrays}

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        return self.meaning.columns

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the columns."""
        return self.meaning.units

    @property
    def frame(self) -> str:
        """The frame in which vectors are expressed."""
        return self.meaning.frame

    @property
    def attributes(self) -> Mapping[str, Any]:
        """Clock, rate and the like of the first recording that brought it."""
        return self.meaning.attributes

    def t_ns(self, start: int, stop: int) -> NDArray[np.int64]:
        """Times (n,) of rows [start, stop), host clock, ns."""
        return self._rows["t_ns"].span(start, stop)

    def values(self, start: int, stop: int) -> NDArray[np.float64]:
        """Values (n, k) of rows [start, stop), SI units; read-only."""
        return self._rows["value"].span(start, stop)

    def stamps(self, kind: Literal["log", "publish", "header"], start: int, stop: int) -> NDArray[np.int64]:
        """Time stamps (n,) as recorded, ns; -1 where the recording has none.

        Parameters
        ----------
        kind : "log", "publish" or "header"
            Which clock wrote the stamps.
        start, stop : int
            First row, and the row after the last.
        """
        return self._rows[f"{kind}_ns"].span(start, stop)
