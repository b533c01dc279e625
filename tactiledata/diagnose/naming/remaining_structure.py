"""Whether a fit leaves structure: in trajectories at large, or in one or two of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.evidence import BEST
from tactiledata.diagnose.naming.thresholds import DecisionThresholds


@dataclass(frozen=True)
class RemainingStructure:
    """What is left of trajectories held out, over what noise alone would leave.

    Physics that is missing shows wherever it acts. A touch that hung on a scrap, or whose slide the simulation ends a
    step too early, is no news of physics: as no gain may hang on two trajectories, structure may not either.

    Parameters
    ----------
    dispersion : float
        Mean square of all trajectories.
    without_worst_two : float
        The same without the two of which most is left.
    worst_two : tuple of str
        Names of these two.
    """

    dispersion: float
    without_worst_two: float
    worst_two: tuple[str, ...] = ()

    @staticmethod
    def of(squares: Array, expected: Array, names: Sequence[str]) -> RemainingStructure:
        """Of sums (t,) of whitened squares, and what noise alone would leave of each (t,)."""
        worst_last = np.argsort(squares - expected, kind="stable")
        others, worst = worst_last[:-BEST], worst_last[-BEST:]
        return RemainingStructure(
            float(squares.sum() / expected.sum()),
            float(squares[others].sum() / expected[others].sum()),
            tuple(names[number] for number in worst[::-1]),
        )

    def is_structure(self, scale: DecisionThresholds) -> bool:
        """Whether it is more than noise in trajectories at large."""
        return self.without_worst_two > scale.dispersion

    def is_in_few(self, scale: DecisionThresholds) -> bool:
        """Whether it is more than noise, yet not without the odd two."""
        return not self.is_structure(scale) and self.dispersion > scale.dispersion
