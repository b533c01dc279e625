"""One recording before it is written: every stream as sampled, every picture as a promise, the truth beside it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from tactiledata.rig.scenario.scenario import ClockSetup, Scenario

Item = TypeVar("Item")


@dataclass(frozen=True)
class Samples:
    """A stream of numbers.

    Parameters
    ----------
    host_ns : (n,) int64
        When each sample was taken, host clock. Known to the rig only.
    stamp_ns : (n,) int64
        The same on the stream's own clock.
    values : (n, k)
    """

    host_ns: NDArray[np.int64]
    stamp_ns: NDArray[np.int64]
    values: NDArray[np.floating[Any]]


@dataclass(frozen=True)
class Shot:
    """One captured moment; ``picture`` draws it, (320, 240, 3) uint8 RGB; ``dropped``: the image was lost."""

    host_ns: int
    stamp_ns: int
    sensor: str
    trajectory: str
    dropped: bool
    picture: Callable[[], NDArray[np.uint8]]


@dataclass(frozen=True)
class Tape:
    """One log, ready to be written.

    Parameters
    ----------
    name : str
        Of the file or folder, without ending.
    index : int
        Its place in the scenario; seeds what writing draws at random.
    description : dict
        Fits ``schemas/log.json``; without trajectories.
    trajectories : tuple of dict
        Rows of trajectories.csv; empty where the log names none.
    signals : dict of Samples
        ``joints`` (n, 6), ``tcp`` (n, 7), ``wrench`` (n, 6), ``arm_wrench`` (n, 6); those that are recorded.
    shots : tuple of Shot, in time
    backgrounds : dict, path inside the log -> (320, 240, 3) uint8 RGB
    files : dict, path inside the log -> Path
        Meshes that go with it.
    truth : dict
        What only the rig knows; JSON values and tables.
    """

    name: str
    index: int
    scenario: Scenario
    description: Mapping[str, Any]
    trajectories: tuple[Mapping[str, Any], ...]
    signals: Mapping[str, Samples]
    shots: tuple[Shot, ...]
    backgrounds: Mapping[str, NDArray[np.uint8]]
    files: Mapping[str, Path] = field(default_factory=dict)
    truth: Mapping[str, Any] = field(default_factory=dict)

    def clock(self, stream: str) -> ClockSetup:
        """The clock of a stream; the decoy shares the joints'."""
        return self.scenario.clock("joints" if stream == "arm_wrench" else stream)

    def rng(self, purpose: int) -> np.random.Generator:
        """Random numbers of this log for one purpose."""
        return np.random.default_rng([self.scenario.seed, 5, self.index, purpose])

    def disordered(self, items: Iterable[Item], purpose: int) -> Iterator[Item]:
        """The items, of which the stated share changes places with its successor."""
        share = self.scenario.imperfections.out_of_order
        if share <= 0:
            yield from items
            return
        rng = self.rng(purpose)
        held: Item | None = None
        for item in items:
            if held is not None:
                yield item
                yield held
                held = None
            elif rng.random() < share:
                held = item
            else:
                yield item
        if held is not None:
            yield held
