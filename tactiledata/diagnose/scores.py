"""What each trajectory says for letting a parameter vary: contributions to a score, and their chance by sign flips."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.projection import Projection

Array = NDArray[np.float64]

FEWEST_EFFECTIVE = 5.0
"""Units of exchange that a score rests on, counted by the weight of their contributions."""


@dataclass(frozen=True)
class Contributions:
    """Scores of c alternatives ``parameter + size * instrument``.

    Parameters
    ----------
    by_unit : (u, c)
        Of each unit of exchange; their sum is the score.
    information : (c,)
        Inverse variance of the sizes, were the noise all there is.
    """

    by_unit: Array
    information: Array

    @property
    def total(self) -> Array:
        """Scores (c,)."""
        return self.by_unit.sum(axis=0)

    @property
    def spread(self) -> Array:
        """Standard deviations (c,) of the scores, from what the units disagree on; 0 where too few contribute."""
        squares = self.by_unit**2
        second = squares.sum(axis=0)
        effective = second**2 / np.maximum((squares**2).sum(axis=0), 1e-300)
        return np.where(effective >= FEWEST_EFFECTIVE, np.sqrt(second), 0.0)

    @property
    def statistic(self) -> Array:
        """Scores over their spread (c,), signed; 0 where too few units contribute."""
        spread = self.spread
        return np.where(spread > 0, self.total / np.where(spread > 0, spread, 1.0), 0.0)

    def flipped(self, signs: Array) -> Array:
        """The statistics (draws, c) with the units' signs (draws, u) thrown anew."""
        spread = self.spread
        scaled = np.where(spread > 0, self.by_unit / np.where(spread > 0, spread, 1.0), 0.0)
        return signs @ scaled

    @property
    def size(self) -> Array:
        """One-step sizes (c,) of the alternatives, in the parameter's unit."""
        return self.total / np.maximum(self.information, 1e-300)


def contributions(projection: Projection, place: int, instruments: Array) -> Contributions:
    """Scores of letting a shared parameter, by its place among them, vary with instruments: see `along`."""
    return along(projection, projection.directions[:, :, place], instruments)


def along(projection: Projection, direction: Array, instruments: Array) -> Contributions:
    """Scores of fields ``instrument * direction``, orthogonal to all shared and own parameters.

    Parameters
    ----------
    direction : (n, k)
        The sensitivity of what varies.
    instruments : (n, c)
        By how much it varies in each frame: steps, slopes, kernels.
    """
    residuals = projection.residuals
    score = np.einsum("nk,nk->n", direction, projection.score)
    with_shared = np.einsum("nk,nkp->np", direction, projection.weighed)
    together = with_shared.T @ instruments
    imitation = projection.inverse @ together
    of_shared = residuals.by_unit(np.einsum("nkp,nk->np", projection.directions, projection.score))
    by_unit = residuals.by_unit(instruments * score[:, None]) - of_shared @ imitation
    information = np.einsum("nk,nk->n", direction, direction) @ instruments**2
    if projection.basis.shape[2]:
        own = np.einsum("nk,nko->no", direction, projection.basis)
        inside = np.add.reduceat(own[:, :, None] * instruments[:, None, :], residuals.starts, axis=0)
        information = information - (inside**2).sum(axis=(0, 1))
    return Contributions(by_unit, np.maximum(information - (together * imitation).sum(axis=0), 0.0))
