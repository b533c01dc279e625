"""Matrices of information, scaled so that a cut-off does not depend on the units of the parameters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array, Mask

LEAST = 1e-290
"""Information below which a direction has none.

A pseudo-inverse of up to 1e12, divided by it, is still a number."""
LEAST_SHARE = 1e-60
"""Share of the largest information of a matrix below which a direction has none; units do not differ by so much."""


@dataclass(frozen=True)
class ScaledMatrix:
    """A symmetric positive matrix with 1 on its diagonal; directions without information are 0 in it.

    Parameters
    ----------
    values : (q, q)
        The scaled matrix.
    scale : (q,)
        Square roots of the diagonal, 1 without information: the matrix is ``values`` times their products.
    has_information : (q,) bool
        Whether the diagonal is large enough. One that is denormal, 0 or, by rounding, negative would scale what is left
        of its row beyond all numbers.
    """

    values: Array
    scale: Array
    has_information: Mask

    def pseudo_inverse(self, rcond: float) -> Array:
        """Return the pseudo-inverse (q, q) of the matrix before it was scaled; 0 in directions without information.

        Parameters
        ----------
        rcond : float
            Share of the largest singular value below which one counts as 0, of the scaled matrix.
        """
        inverse = np.linalg.pinv(self.values, rcond=rcond, hermitian=True) / np.outer(self.scale, self.scale)
        # rounding leaves something in rows of zeros
        kept: Array = np.where(np.outer(self.has_information, self.has_information), inverse, 0.0)
        return kept

    @property
    def log_determinant(self) -> float:
        """Logarithm of the determinant over the directions with information."""
        filled = self.values + np.diag(np.where(self.has_information, 0.0, 1.0))
        return float(np.linalg.slogdet(filled)[1] + 2.0 * np.log(self.scale).sum())


def scaled_matrix(matrix: Array) -> ScaledMatrix:
    """Return a matrix scaled to 1 on its diagonal.

    Parameters
    ----------
    matrix : (q, q)
        Symmetric and positive, up to rounding.
    """
    diagonal = np.diag(matrix)
    felt = diagonal > max(LEAST, LEAST_SHARE * float(diagonal.max(initial=0.0)))
    scale = np.sqrt(np.where(felt, diagonal, 1.0))
    return ScaledMatrix(np.where(np.outer(felt, felt), matrix, 0.0) / np.outer(scale, scale), scale, felt)
