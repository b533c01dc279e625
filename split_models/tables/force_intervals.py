"""Forces with intervals of guaranteed coverage: an ensemble of heads, calibrated on trajectories new to all of them.

Frames of a touch resemble each other, so that trajectories, not frames, are exchangeable. Every trajectory has the same
weight, shared by its frames, and the new trajectory has that weight at infinity. Then an interval of a frame of a new
trajectory holds the truth with at least the nominal probability, however good the heads are.

Source: Lee, Barber and Willett, Distribution-free inference with hierarchical data, 2023.
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
"""Probability with which an interval holds the truth."""
FLOOR = 0.05
"""Amount that is added to the heads' disagreement, as a share of the forces' spread over the train part."""


@dataclass(frozen=True)
class CalibratedEnsemble:
    """Calibration of intervals from several heads' forces of the same frames.

    Parameters
    ----------
    factors : (3,)
        Half the width of the intervals of fx, fy and fz, divided by the heads' standard deviation plus the floor.
    floor : (3,) N
        Amount that is added to the heads' standard deviation.
    level : float
        Probability that an interval holds the truth, for each component separately.
    """

    factors: Array
    floor: Array
    level: float

    @classmethod
    def fitted(cls, forces: Any, true: Any, trajectories: Any, floor: Any, level: float = LEVEL) -> CalibratedEnsemble:
        """The calibration on frames that no head has learned from.

        Parameters
        ----------
        forces : (h, n, 3) N
            Forces from two or more heads.
        true : (n, 3) N
            Measured forces.
        trajectories : (n,) str
            Trajectory of each frame.
        floor : (3,) N
            Amount that is added to the heads' standard deviation.
        level : float
            Probability that an interval holds the truth.

        Raises
        ------
        UsageError
            There is only one head, or there are too few trajectories for the level.
        """
        if len(forces) < 2:
            raise UsageError(f"{len(forces)} head", "two or more heads, to measure disagreement", "Raise `head_seeds`.")
        count, least = len(set(trajectories)), least_trajectories(level)
        if count < least:
            raise UsageError(
                f"{count} trajectories to calibrate intervals of {level:.0%} on", f"{least} or more", "Lower the level."
            )
        mean, spread = _moments(forces, floor)
        scores = np.abs(np.asarray(true) - mean) / spread
        factors = np.array([group_quantile(score, trajectories, level) for score in scores.T])
        return cls(factors, np.asarray(floor, np.float64), level)

    def intervals(self, forces: Any) -> tuple[Array, Array]:
        """Mean forces (n, 3), N, and their intervals (n, 3, 2), N, from the forces (h, n, 3), N, of all heads."""
        mean, spread = _moments(forces, self.floor)
        half = self.factors * spread
        return mean, np.stack([mean - half, mean + half], axis=-1)


@dataclass(frozen=True)
class ForceIntervals:
    """Force heads that give an interval with each force.

    Parameters
    ----------
    heads : sequence of Forces
        Networks of the same kind, trained with different seeds.
    calibrated : CalibratedEnsemble
    """

    heads: Sequence[Forces]
    calibrated: CalibratedEnsemble

    @classmethod
    def fitted(
        cls, heads: Sequence[Forces], given: Tensor, true: Any, trajectories: Any, level: float = LEVEL
    ) -> ForceIntervals:
        """Heads of several seeds, calibrated on frames that none has learned from.

        Parameters
        ----------
        heads : sequence of Forces
        given : (n, ...) Tensor
            Inputs of the heads.
        true : (n, 3) N
            Measured forces.
        trajectories : (n,) str
            Trajectory of each frame.
        level : float
            Probability that an interval holds the truth.

        Raises
        ------
        UsageError
            There is only one head, or there are too few trajectories for the level.
        """
        forces = forces_of_heads(heads, given)
        return cls(heads, CalibratedEnsemble.fitted(forces, true, trajectories, floor_of(heads), level))

    def predict(self, given: Tensor) -> tuple[Array, Array]:
        """Forces (n, 3), N, and their intervals (n, 3, 2), N, for inputs of the heads (n, ...)."""
        return self.calibrated.intervals(forces_of_heads(self.heads, given))


def forces_of_heads(heads: Sequence[Forces], given: Tensor) -> Array:
    """Forces (h, n, 3), N, that each head predicts for the same inputs (n, ...)."""
    with torch.no_grad():
        return np.stack([head.eval().forces(given.to(head.device)).double().cpu().numpy() for head in heads])


def floor_of(heads: Sequence[Forces]) -> Array:
    """Amount (3,), N, that is added to the disagreement of heads: `FLOOR` times the forces' spread."""
    floor: Array = FLOOR * heads[0].spread.double().cpu().numpy()
    return floor


def least_trajectories(level: float) -> int:
    """Least number of trajectories that a level can be calibrated on; with fewer the intervals would be infinite."""
    return int(np.ceil(level / (1 - level) - 1e-9))


def group_quantile(scores: Any, groups: Any, level: float) -> float:
    """Quantile of scores (n,) when each of k groups has weight 1 / (k + 1), and infinity the rest.

    Parameters
    ----------
    scores : (n,)
    groups : (n,) str
        Group of each score; its scores share the group's weight equally.
    level : float
        Level of the quantile.

    Returns
    -------
    float
        One of the scores, or infinity where their weights do not reach the level.
    """
    _, group, counts = np.unique(np.asarray(groups, dtype=str), return_inverse=True, return_counts=True)
    order = np.argsort(scores, kind="stable")
    reached = np.cumsum(1.0 / counts[group[order]]) / (len(counts) + 1)
    place = int(np.searchsorted(reached, level - 1e-12))
    return float(np.asarray(scores)[order][place]) if place < len(order) else float("inf")


def _moments(forces_of_heads: Any, floor: Any) -> tuple[Array, Array]:
    """Mean of the heads' forces, and their standard deviation plus the floor, (n, 3) each, N."""
    forces = np.asarray(forces_of_heads, np.float64)
    return forces.mean(axis=0), forces.std(axis=0, ddof=1) + np.asarray(floor, np.float64)
