"""Forces with intervals that hold what they promise: an ensemble of heads, calibrated on trajectories it has not seen.

Frames of a touch resemble each other, so that trajectories, not frames, are what is exchangeable. Source: Lee, Barber
and Willett, Distribution-free inference with hierarchical data, 2023: every trajectory has the same weight, shared by
its frames, and the one that is to come has that weight at infinity. Then an interval of a frame of a new trajectory
holds the truth with the nominal probability at least, whatever the heads are worth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor

from split_models.networks.force_head import Forces
from tactiledata.arrays import Array
from tactiledata.errors import UsageError

LEVEL = 0.9
FLOOR = 0.05
"""Disagreement of heads below this share of the forces' spread over the train part counts as so much."""


@dataclass(frozen=True)
class CalibratedEnsemble:
    """Intervals from several heads' forces of the same frames.

    Parameters
    ----------
    factors : (3,)
        Half the width of fx, fy and fz over the heads' standard deviation and the floor.
    floor : (3,) N
    level : float
        Probability that an interval holds the truth, each component by itself.
    """

    factors: Array
    floor: Array
    level: float

    @classmethod
    def fitted(cls, found: Any, true: Any, trajectories: Any, floor: Any, level: float = LEVEL) -> CalibratedEnsemble:
        """Calibrated on frames that no head has learned from.

        Parameters
        ----------
        found : (h, n, 3) N
            Of two or more heads.
        true : (n, 3) N
        trajectories : (n,)
            Names.
        floor : (3,) N
        level : float

        Raises
        ------
        UsageError
            One head only, or too few trajectories for the level.
        """
        if len(found) < 2:
            raise UsageError(f"{len(found)} head", "two or more, whose disagreement is used", "Raise `head_seeds`.")
        count, least = len(set(trajectories)), least_trajectories(level)
        if count < least:
            raise UsageError(
                f"{count} trajectories to calibrate intervals of {level:.0%} on", f"{least} or more", "Lower the level."
            )
        middle, spread = _moments(found, floor)
        scores = np.abs(np.asarray(true) - middle) / spread
        factors = np.array([group_quantile(score, trajectories, level) for score in scores.T])
        return cls(factors, np.asarray(floor, np.float64), level)

    def intervals(self, found: Any) -> tuple[Array, Array]:
        """Forces (n, 3), N, and their intervals (n, 3, 2), N, of heads' forces (h, n, 3)."""
        middle, spread = _moments(found, self.floor)
        half = self.factors * spread
        return middle, np.stack([middle - half, middle + half], axis=-1)


@dataclass(frozen=True)
class ForceIntervals:
    """Force heads that say how sure they are.

    Parameters
    ----------
    heads : sequence of Forces
    calibrated : CalibratedEnsemble
    """

    heads: Sequence[Forces]
    calibrated: CalibratedEnsemble

    @classmethod
    def fitted(
        cls, heads: Sequence[Forces], given: Tensor, true: Any, trajectories: Any, level: float = LEVEL
    ) -> ForceIntervals:
        """Heads of several seeds, calibrated on what they take (n, ...), of forces (n, 3), N, and trajectories (n,).

        Raises
        ------
        UsageError
            One head only, or too few trajectories for the level.
        """
        found = forces_of_heads(heads, given)
        return cls(heads, CalibratedEnsemble.fitted(found, true, trajectories, floor_of(heads), level))

    def predict(self, given: Tensor) -> tuple[Array, Array]:
        """Forces (n, 3), N, and their intervals (n, 3, 2), N, of what the heads take (n, ...)."""
        return self.calibrated.intervals(forces_of_heads(self.heads, given))


def forces_of_heads(heads: Sequence[Forces], given: Tensor) -> Array:
    """Forces (h, n, 3), N, of what the heads take."""
    with torch.no_grad():
        return np.stack([head.eval().forces(given.to(head.device)).double().cpu().numpy() for head in heads])


def floor_of(heads: Sequence[Forces]) -> Array:
    """Smallest disagreement (3,), N, that counts."""
    floor: Array = FLOOR * heads[0].spread.double().cpu().numpy()
    return floor


def least_trajectories(level: float) -> int:
    """How many trajectories a level needs: with fewer the interval would have to be endless."""
    return int(np.ceil(level / (1 - level) - 1e-9))


def group_quantile(scores: Any, groups: Any, level: float) -> float:
    """The quantile of scores (n,) where each of k groups has the weight 1 / (k + 1), and infinity the rest."""
    _, group, counts = np.unique(np.asarray(groups, dtype=str), return_inverse=True, return_counts=True)
    order = np.argsort(scores, kind="stable")
    reached = np.cumsum(1.0 / counts[group[order]]) / (len(counts) + 1)
    place = int(np.searchsorted(reached, level - 1e-12))
    return float(np.asarray(scores)[order][place]) if place < len(order) else float("inf")


def _moments(found: Any, floor: Any) -> tuple[Array, Array]:
    """Mean of the heads and what their disagreement counts as, both (n, 3)."""
    forces = np.asarray(found, np.float64)
    return forces.mean(axis=0), forces.std(axis=0, ddof=1) + np.asarray(floor, np.float64)
