"""Score tests of a parameter that varies: each unit's contribution, and studentised statistics under sign flips."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.projection import ProjectedResiduals

FEWEST_EFFECTIVE = 5.0
"""Fewest effective units of exchange (weighted by information) for an alternative to be tested."""
ROUNDING = 1e-12
"""Least variance of a score, as a share of its sum of squares: smaller values are rounding errors."""
IMITATED = 1e-9
"""Least share of an alternative's information that must remain after projection; with less it is a linear
combination of the parameters."""


@dataclass(frozen=True)
class Refit:
    """What is needed to refit the p shared parameters after the signs of u units of exchange are flipped.

    Parameters
    ----------
    scores : (u, p)
        Score of each unit for each shared parameter.
    inverse : (p, p)
        Inverse of the information matrix of the shared parameters.
    together : (u, p, c)
        Inner products of the c orthogonalised alternatives with the shared parameters, in each unit; the sums over
        units are 0.
    """

    scores: Array
    inverse: Array
    together: Array

    def change_of_variance(self, signs: Array, size: Array, by_unit: Array, information_by_unit: Array) -> Array:
        """Return the change (draws, c) of the sums of squares of the units' scores, caused by the refit.

        Parameters
        ----------
        signs : (draws, u)
            Sign of each unit in each draw.
        size : (draws, c)
            Fitted size of each alternative in each draw.
        by_unit, information_by_unit : (u, c)
            As in `Contributions`.
        """
        same = self._by_units
        moved = signs @ same.scores @ same.inverse
        total = 2.0 * size * (moved @ np.einsum("uc,upc->pc", information_by_unit, same.together))
        both = np.concatenate([moved, signs], axis=1)
        for place, column in enumerate(moved.T):
            crossed = np.concatenate([same._squares[:, place].T, -2.0 * by_unit * same.together[:, place]])
            total += column[:, None] * (both @ crossed)
        return total

    @cached_property
    def _by_units(self) -> Refit:
        """Return the same refits by as many numbers as there are units, where the shared parameters are more.

        The refit moves along the rows of ``scores @ inverse`` only, by the sign of each unit.
        """
        units, shared = self.scores.shape
        if units >= shared:
            return self
        return Refit(np.eye(units), np.eye(units), (self.scores @ self.inverse) @ self.together)

    @cached_property
    def _squares(self) -> Array:
        """Products (c, p, p) of each alternative's columns of ``together``."""
        columns = self.together.transpose(2, 1, 0)
        return columns @ columns.transpose(0, 2, 1)


@dataclass(frozen=True)
class Contributions:
    """Scores of c alternatives ``parameter + size * instrument``, one contribution from each of u units of exchange.

    Parameters
    ----------
    by_unit : (u, c)
        Contribution of each unit; the sum over units is the score.
    information_by_unit : (u, c)
        Fisher information of each unit on the size: its inverse variance if there were nothing but noise.
    refit : Refit, optional
        How the shared parameters are refitted when signs are flipped; ``None`` where there are none.
    """

    by_unit: Array
    information_by_unit: Array
    refit: Refit | None = None

    @cached_property
    def information(self) -> Array:
        """Fisher information (c,) of all units together on the size of each alternative."""
        return np.maximum(self.information_by_unit.sum(axis=0), 0.0)

    @cached_property
    def effective(self) -> Array:
        """Effective number of units (c,) that each alternative rests on, each weighted by its information."""
        return self.information**2 / np.maximum((self.information_by_unit**2).sum(axis=0), 1e-300)

    @property
    def is_testable(self) -> NDArray[np.bool_]:
        """Mask (c,) of the alternatives that rest on at least `FEWEST_EFFECTIVE` effective units."""
        return np.asarray((self.effective >= FEWEST_EFFECTIVE) & (self.by_unit != 0).any(axis=0))

    @property
    def statistic(self) -> Array:
        """Size over standard error (c,), as signed standard normal values; 0 where too few units contribute."""
        return self.flipped(np.ones((1, len(self.by_unit))))[0]

    def flipped(self, signs: Array) -> Array:
        """Return the statistics (draws, c) after each unit's contribution is multiplied by its sign (draws, u).

        Standard errors are those of a fit that includes the alternative, with all shared parameters refitted after the
        flips: otherwise a strong alternative would inflate its own standard error. Alternatives that rest on few units
        have wide tails; Wallace's (1959) transformation makes their values comparable with those of others.
        """
        information = np.maximum(self.information, 1e-300)
        score = signs @ self.by_unit
        size = score / information
        # variance of the score around the fitted size, from what the units disagree on
        mixed = signs @ (self.by_unit * self.information_by_unit)
        second, carried = (self.by_unit**2).sum(axis=0), (self.information_by_unit**2).sum(axis=0)
        variance = second - 2.0 * size * mixed + size**2 * carried
        if self.refit is not None:
            variance += self.refit.change_of_variance(signs, size, self.by_unit, self.information_by_unit)
        variance = np.maximum(variance, ROUNDING * second)
        # Student's t with the effective degrees of freedom, transformed to a standard normal value
        freedom = np.maximum(self.effective - 1.0, 1.0)
        student = score**2 / np.where(variance > 0, variance, 1.0) / freedom * (freedom / (freedom + 1.0))
        normal = np.sqrt(freedom * np.log1p(student)) * ((8.0 * freedom + 1.0) / (8.0 * freedom + 3.0))
        return np.where(self.is_testable, np.copysign(normal, score), 0.0)

    def part(self, chosen: NDArray[np.bool_]) -> Contributions:
        """Return the contributions of the alternatives in a mask (c,)."""
        refit = None if self.refit is None else replace(self.refit, together=self.refit.together[:, :, chosen])
        return Contributions(self.by_unit[:, chosen], self.information_by_unit[:, chosen], refit)

    @property
    def size(self) -> Array:
        """Fitted size (c,) of each alternative, by one linear step, in the parameter's unit; 0 without information."""
        is_known = self.information > 0
        return np.where(is_known, self.by_unit.sum(axis=0) / np.where(is_known, self.information, 1.0), 0.0)


def contributions(projection: ProjectedResiduals, place: int, instruments: Array) -> Contributions:
    """Return scores of one shared parameter varying with each of c instruments, one from each unit of exchange.

    They are those of `along` with the field that a change of the parameter makes.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals of n frames after the refit.
    place : int
        Index of the parameter in `Residuals.shared`.
    instruments : (n, c)
        By how much the parameter varies in each frame.
    """
    return along(projection, projection.directions[:, :, place], instruments)


def along(projection: ProjectedResiduals, direction: Array, instruments: Array) -> Contributions:
    """Return the scores of c alternatives, in each of which a parameter or a component varies as an instrument says.

    The field of an alternative, ``instrument * direction``, is made orthogonal to all shared parameters and to the
    trajectories' own, so that nothing counts that a refit of these could imitate.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals of n frames after the refit.
    direction : (n, k)
        Whitened sensitivity of what varies: of a parameter, or the unit direction of a component.
    instruments : (n, c)
        By how much it varies in each frame: steps, slopes, kernels.
    """
    residuals = projection.residuals
    # products with the shared parameters, and the combination of them that imitates each alternative
    row = direction[:, None, :]
    score = np.einsum("nk,nk->n", direction, projection.score)
    factors = [score[:, None], (row @ projection.weighed)[:, 0], (row @ projection.basis)[:, 0]]
    products = residuals.products(np.concatenate(factors, axis=1), instruments)
    scored, together, inside = np.split(products, np.cumsum([1, projection.weighed.shape[2]]), axis=1)
    together = residuals.units_of(together)
    imitation = projection.inverse @ together.sum(axis=0)
    of_shared, shared = projection.score_by_unit, projection.information_by_unit
    by_unit = residuals.units_of(scored[:, 0]) - of_shared @ imitation
    # information of each unit, less what own parameters and then the shared ones absorb
    information = residuals.by_unit(instruments**2 * np.einsum("nk,nk->n", direction, direction)[:, None])
    information = information - residuals.units_of((inside**2).sum(axis=1))
    alone = information.sum(axis=0)
    information = information - 2.0 * np.einsum("upc,pc->uc", together, imitation)
    information = information + np.einsum("pc,upq,qc->uc", imitation, shared, imitation, optimize=True)
    left = together - shared @ imitation
    # an alternative that the parameters imitate leaves rounding errors only: its score is set to 0
    is_more = information.sum(axis=0) > IMITATED * alone
    refit = Refit(of_shared, projection.inverse, left * is_more)
    return Contributions(by_unit * is_more, np.maximum(information, 0.0) * is_more, refit)


def joined_refits(refits: Sequence[Refit | None]) -> Refit | None:
    """Return one refit for the alternatives of several contributions, concatenated; ``None`` where none has a refit."""
    known = [refit for refit in refits if refit is not None]
    if not known:
        return None
    return Refit(known[0].scores, known[0].inverse, np.concatenate([refit.together for refit in known], axis=2))


def cosines_of(products: Array, squares: Array) -> Array:
    """Return the cosines (k, k) of k fields from their products; 0 for fields that are all but taken out.

    Parameters
    ----------
    products : (k, k)
        Inner products of what is left of the fields after projection.
    squares : (k,)
        Sums of squares of the whole fields. With no more than ``IMITATED`` of it left, a field has no direction.
    """
    left = np.diag(products)
    has_direction = left > IMITATED * squares
    size = np.sqrt(np.where(has_direction, left, 1.0))
    is_known = np.outer(has_direction, has_direction)
    return np.where(is_known, np.clip(products / np.outer(size, size), -1.0, 1.0), 0.0)
