"""Hidden faults of a clock: a wrong rate, and jumps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tactiledata.arrays import RealArray
from tactiledata.rig.hidden.base import HiddenEffect, Parameters, Times


@dataclass(frozen=True)
class HiddenClockSkew(HiddenEffect):
    """The force sensor's clock runs fast, and jumps back at regular times, as its counter loses samples.

    stamp = true stamp + skew t - jump floor(t / every), t since the log's start; stamps never fall.

    Parameters
    ----------
    skew : float
        Relative error of the rate; 1e-5 is 10 ppm.
    jump, every : s
        Size of a jump, and time between two of them.
    """

    NUMBER: ClassVar[str] = "19"
    ACTS: ClassVar[str] = "clock"
    SOURCE: ClassVar[str] = "a quartz's error and a counter that loses samples"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"skew": 2e-5, "jump": 0.004},
        "medium": {"skew": 5e-5, "jump": 0.008},
        "strong": {"skew": 1e-4, "jump": 0.016},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {
        "skew": (-0.01, 0.01),
        "jump": (-0.1, 0.1),
        "every": (1.0, 1e5),
    }
    skew: float = 0.0
    jump: float = 0.0
    every: float = 60.0

    def stamped(self, stream: str, stamps: Times, seconds: RealArray) -> Times:
        """Return the stamps (n,), ns, of the force sensor with skew and jumps; those of other streams unchanged.

        Parameters
        ----------
        stream : str
            Name of the stream.
        stamps : (n,), ns
            Stamps without the effect.
        seconds : (n,)
            Times of the samples since the log's start.
        """
        if stream != "wrench":
            return stamps
        off = self.skew * seconds - self.jump * np.floor(seconds / self.every)
        skewed = stamps + np.rint(off * 1e9).astype(np.int64)
        # a later sample is at least a nanosecond later
        order = np.arange(len(skewed))
        return np.maximum.accumulate(skewed - order) + order
