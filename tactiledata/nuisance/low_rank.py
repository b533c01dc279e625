"""Powers of a covariance that is the identity plus a few directions: what a trajectory's own unknowns add to noise."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array, Indices

SMALLEST = 1e-12
"""Floor of an eigenvalue, as a share of the largest one."""


def low_rank_power(rows: Array, fields: Array, starts: Indices, power: float) -> Array:
    """Multiply whitened rows by a power of the covariance I + F Fᵀ of their trajectory.

    Unknowns b ~ N(0, I) of one trajectory, as the zero of its force sensor, change its whitened rows by F b. Power -1/2
    marginalises them: the squares of the rows returned sum to the deviance. Power 1/2 undoes that.

    Parameters
    ----------
    rows : (n, k, c)
        Whitened wrenches of k components, c columns side by side.
    fields : (n, k, r)
        F: the change of each row over one standard deviation of each of r unknowns of its trajectory.
    starts : (t,)
        First row of each trajectory.
    power : float
        Exponent of the covariance.
    """
    counts = np.diff(starts, append=len(rows))
    products = np.add.reduceat(np.einsum("nkr,nks->nrs", fields, fields), starts)
    values, axes = np.linalg.eigh(products)
    floor = SMALLEST * np.maximum(values.max(axis=1, keepdims=True), 1e-300)
    eigenvalues = np.maximum(values, floor)
    # (I + F Fᵀ)^p = I + F core Fᵀ, with the eigenvectors of Fᵀ F
    scale = ((1.0 + eigenvalues) ** power - 1.0) / eigenvalues
    core = (axes * scale[:, None, :]) @ axes.transpose(0, 2, 1)
    sums = core @ np.add.reduceat(np.einsum("nkr,nkc->nrc", fields, rows), starts)
    changed: Array = rows + np.einsum("nkr,nrc->nkc", fields, np.repeat(sums, counts, axis=0))
    return changed
