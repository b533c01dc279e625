"""Whether a fit leaves more than noise, and whether it does so in most trajectories or in one or two."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.evidence import MOST_INFLUENTIAL
from tactiledata.diagnose.naming.thresholds import DecisionThresholds


@dataclass(frozen=True)
class RemainingStructure:
    """Mean square that a fit leaves of held-out trajectories, over the mean square that noise alone would leave.

    Missing physics shows in every touch in which it acts. One or two bad touches (debris, a slide simulated one step
    short) must not count as missing physics: the two worst trajectories are therefore ignored.

    Parameters
    ----------
    dispersion : float
        Ratio over all trajectories; 1 where noise is all that is left.
    without_worst_two : float
        The same ratio without the two trajectories that exceed their noise most.
    worst_two : tuple of str
        Names of these two trajectories, the worst first.
    """

    dispersion: float
    without_worst_two: float
    worst_two: tuple[str, ...] = ()

    @staticmethod
    def of(squares: Array, expected: Array, names: Sequence[str]) -> RemainingStructure:
        """Return what held-out trajectories leave, from their sums of squares.

        Parameters
        ----------
        squares : (t,)
            Sum of whitened squares of each trajectory.
        expected : (t,)
            Sum of whitened squares that noise alone would leave of each trajectory.
        names : sequence of str
            Name of each trajectory.
        """
        worst_last = np.argsort(squares - expected, kind="stable")
        others, worst = worst_last[:-MOST_INFLUENTIAL], worst_last[-MOST_INFLUENTIAL:]
        return RemainingStructure(
            float(squares.sum() / expected.sum()),
            float(squares[others].sum() / expected[others].sum()),
            tuple(names[number] for number in worst[::-1]),
        )

    def is_structure(self, thresholds: DecisionThresholds) -> bool:
        """Whether more than noise is left even without the two worst trajectories."""
        return self.without_worst_two > thresholds.structure_dispersion

    def is_in_few(self, thresholds: DecisionThresholds) -> bool:
        """Whether more than noise is left of all trajectories, but not without the two worst."""
        return not self.is_structure(thresholds) and self.dispersion > thresholds.structure_dispersion
