"""What each trajectory says for letting a parameter vary: contributions to a score, and their chance by sign flips."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.projection import ProjectedResiduals

FEWEST_EFFECTIVE = 5.0
"""Units of exchange that an alternative rests on, counted by their information."""
ROUNDING = 1e-12
IMITATED = 1e-9
"""Share of an alternative's information that must be left beside the parameters."""


@dataclass(frozen=True)
class Refit:
    """Shared parameters that are fitted anew to residuals with other signs.

    Parameters
    ----------
    scores : (u, p)
        Of the units of exchange, for the shared parameters.
    inverse : (p, p)
        Of their information.
    together : (u, p, c)
        Products of the alternatives, made orthogonal, with the shared parameters, in each unit; their sums are 0.
    """

    scores: Array
    inverse: Array
    together: Array

    def change_of_variance(self, signs: Array, size: Array, by_unit: Array, information_by_unit: Array) -> Array:
        """What the refit adds (draws, c) to the sums of squares of the units' scores."""
        moved = signs @ self.scores @ self.inverse
        total = np.zeros_like(size)
        squares = np.einsum("upc,uqc->pqc", self.together, self.together)
        for place, column in enumerate(moved.T):
            here = self.together[:, place]
            carried = np.einsum("uc,uc->c", information_by_unit, here)
            total += 2.0 * column[:, None] * (size * carried - signs @ (by_unit * here))
            total += column[:, None] * (moved @ squares[place])
        return total


@dataclass(frozen=True)
class Contributions:
    """Scores of c alternatives ``parameter + size * instrument``.

    Parameters
    ----------
    by_unit : (u, c)
        Of each unit of exchange; their sum is the score.
    information_by_unit : (u, c)
        What each unit tells of the size: inverse variances, were the noise all there is.
    refit : Refit, optional
        How the shared parameters follow where signs are thrown anew; ``None``: there are none.
    """

    by_unit: Array
    information_by_unit: Array
    refit: Refit | None = None

    @cached_property
    def information(self) -> Array:
        """Of all units together (c,)."""
        return np.maximum(self.information_by_unit.sum(axis=0), 0.0)

    @cached_property
    def effective(self) -> Array:
        """Units that each alternative rests on (c,), counted by their information."""
        return self.information**2 / np.maximum((self.information_by_unit**2).sum(axis=0), 1e-300)

    @property
    def is_testable(self) -> NDArray[np.bool_]:
        """Alternatives (c,) on which units enough have something to say."""
        return np.asarray((self.effective >= FEWEST_EFFECTIVE) & (self.by_unit != 0).any(axis=0))

    @property
    def statistic(self) -> Array:
        """Sizes over their standard errors (c,), as signed standard normal values; 0 where too few units contribute."""
        return self.flipped(np.ones((1, len(self.by_unit))))[0]

    def flipped(self, signs: Array) -> Array:
        """The statistics (draws, c) with the units' signs (draws, u) thrown anew.

        Standard errors are those of the fit with the alternative, all shared parameters refitted to the thrown signs,
        so that a strong alternative does not hide behind the scatter that it causes itself. Alternatives that rest on
        few units have wide tails; Wallace's (1959) transformation makes their values comparable with those of others.
        """
        informed = np.maximum(self.information, 1e-300)
        score = signs @ self.by_unit
        size = score / informed
        mixed = signs @ (self.by_unit * self.information_by_unit)
        second, carried = (self.by_unit**2).sum(axis=0), (self.information_by_unit**2).sum(axis=0)
        variance = second - 2.0 * size * mixed + size**2 * carried
        if self.refit is not None:
            variance += self.refit.change_of_variance(signs, size, self.by_unit, self.information_by_unit)
        variance = np.maximum(variance, ROUNDING * second)
        freedom = np.maximum(self.effective - 1.0, 1.0)
        student = score**2 / np.where(variance > 0, variance, 1.0) / freedom * (freedom / (freedom + 1.0))
        normal = np.sqrt(freedom * np.log1p(student)) * ((8.0 * freedom + 1.0) / (8.0 * freedom + 3.0))
        return np.where(self.is_testable, np.copysign(normal, score), 0.0)

    def part(self, chosen: NDArray[np.bool_]) -> Contributions:
        """Some of the alternatives, by a mask (c,)."""
        refit = None if self.refit is None else replace(self.refit, together=self.refit.together[:, :, chosen])
        return Contributions(self.by_unit[:, chosen], self.information_by_unit[:, chosen], refit)

    @property
    def size(self) -> Array:
        """One-step sizes (c,) of the alternatives, in the parameter's unit."""
        is_known = self.information > 0
        return np.where(is_known, self.by_unit.sum(axis=0) / np.where(is_known, self.information, 1.0), 0.0)


def contributions(projection: ProjectedResiduals, place: int, instruments: Array) -> Contributions:
    """Scores of letting a shared parameter, by its place among them, vary with instruments: see `along`."""
    return along(projection, projection.directions[:, :, place], instruments)


def along(projection: ProjectedResiduals, direction: Array, instruments: Array) -> Contributions:
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
    together = np.zeros((residuals.unit_count, with_shared.shape[1], instruments.shape[1]))
    for place in range(with_shared.shape[1]):
        together[:, place] = residuals.by_unit(with_shared[:, place, None] * instruments)
    imitation = projection.inverse @ together.sum(axis=0)
    of_shared = residuals.by_unit(np.einsum("nkp,nk->np", projection.directions, projection.score))
    by_unit = residuals.by_unit(instruments * score[:, None]) - of_shared @ imitation
    information = residuals.by_unit(instruments**2 * np.einsum("nk,nk->n", direction, direction)[:, None])
    if projection.basis.shape[2]:
        own = np.einsum("nk,nko->no", direction, projection.basis)
        inside = np.add.reduceat(own[:, :, None] * instruments[:, None, :], residuals.starts, axis=0)
        information = information - residuals.units_of((inside**2).sum(axis=1))
    shared = residuals.by_unit(np.einsum("nkp,nkq->npq", projection.directions, projection.weighed))
    alone = information.sum(axis=0)
    information = information - 2.0 * np.einsum("upc,pc->uc", together, imitation)
    information = information + np.einsum("pc,upq,qc->uc", imitation, shared, imitation, optimize=True)
    left = together - np.einsum("upq,qc->upc", shared, imitation)
    # an alternative that the parameters imitate leaves rounding errors, which are no scores
    is_more = information.sum(axis=0) > IMITATED * alone
    refit = Refit(of_shared, projection.inverse, left * is_more)
    return Contributions(by_unit * is_more, np.maximum(information, 0.0) * is_more, refit)


def joined_refits(refits: Sequence[Refit | None]) -> Refit | None:
    """The refit of the alternatives of several contributions, one after another."""
    known = [one for one in refits if one is not None]
    if not known:
        return None
    return Refit(known[0].scores, known[0].inverse, np.concatenate([one.together for one in known], axis=2))
