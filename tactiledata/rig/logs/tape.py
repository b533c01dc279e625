"""One recording before it is written: its streams as sampled, its pictures still to be drawn, and the truth."""

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
    """A sampled stream of numbers.

    Parameters
    ----------
    host_ns : (n,) int64
        Moments of sampling, ns of the host clock. Known to the rig only.
    stamp_ns : (n,) int64
        Their stamps, ns of the stream's own clock.
    values : (n, k)
        Samples, SI units.
    """

    host_ns: NDArray[np.int64]
    stamp_ns: NDArray[np.int64]
    values: NDArray[np.floating[Any]]


@dataclass(frozen=True)
class Shot:
    """One captured moment of a camera.

    Parameters
    ----------
    host_ns, stamp_ns : int
        Moment on the host clock and on the stream's own clock, ns.
    sensor : str
        Serial of the sensor.
    trajectory : str
        Name of the trajectory; empty between trajectories and where the log names none.
    dropped : bool
        Whether the image was lost.
    picture : callable
        Draws the picture, (320, 240, 3) uint8 RGB.
    """

    host_ns: int
    stamp_ns: int
    sensor: str
    trajectory: str
    dropped: bool
    picture: Callable[[], NDArray[np.uint8]]


@dataclass(frozen=True)
class Tape:
    """One log, ready to be written as a file or a folder.

    Parameters
    ----------
    name : str
        Name of the file or folder, without ending.
    index : int
        Place of the log in the scenario; seeds what writing draws at random.
    scenario : Scenario
        The world that was recorded.
    description : dict
        Fits ``schemas/log.json``; without trajectories.
    trajectories : tuple of dict
        Rows of trajectories.csv; empty where the log names none.
    signals : dict of Samples
        ``joints`` (n, 6), ``tcp`` (n, 7), ``wrench`` (n, 6), ``arm_wrench`` (n, 6); those that are recorded.
    shots : tuple of Shot, in time
    backgrounds : dict, path inside the log -> (320, 240, 3) uint8 RGB
    files : dict, path inside the log -> Path
        Mesh files that are copied into the log.
    truth : dict
        What only the rig knows: the `PlayedLog` under ``played_log``.
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
        """Return the clock of a stream; the arm's own force sensor shares the clock of the joints."""
        return self.scenario.clock("joints" if stream == "arm_wrench" else stream)

    def rng(self, purpose: int) -> np.random.Generator:
        """Return the random numbers of this log for one purpose."""
        return np.random.default_rng([self.scenario.seed, 5, self.index, purpose])

    def disordered(self, items: Iterable[Item], purpose: int) -> Iterator[Item]:
        """Yield the items; the scenario's share of them change places with their successors."""
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
