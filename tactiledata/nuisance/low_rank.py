"""Powers of a covariance that is the identity plus a few directions: what a trajectory's own unknowns add to noise."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array, Indices

SMALLEST = 1e-12
"""Floor of an eigenvalue, as a share of the largest one."""


def low_rank_power(rows: Array, fields: Array, starts: Indices, power: float) -> Array:
    """Multiply whitened rows (n, k, c) by a power of the covariance I + F Fᵀ of their trajectory.

    It is `low_rank_product` with the core of that power.

    Parameters
    ----------
    rows : (n, k, c)
        Whitened wrenches of k components, c columns side by side.
    fields, starts, power
        As in `low_rank_core`.
    """
    return low_rank_product(rows, fields, starts, low_rank_core(fields, starts, power))


def low_rank_core(fields: Array, starts: Indices, power: float) -> Array:
    """Return the matrices (t, r, r) C with which (I + F Fᵀ)^p = I + F C Fᵀ, one for each trajectory.

    Parameters
    ----------
    fields : (n, k, r)
        F: the change of each row over one standard deviation of each of r unknowns of its trajectory.
    starts : (t,)
        First row of each trajectory.
    power : float
        Exponent p of the covariance.
    """
    flat = fields.reshape(-1, fields.shape[2])
    products = np.stack([part.T @ part for part in _parts(flat, fields, starts)])
    values, axes = np.linalg.eigh(products)
    floor = SMALLEST * np.maximum(values.max(axis=1, keepdims=True), 1e-300)
    eigenvalues = np.maximum(values, floor)
    # with the eigenvectors of FᵀF
    scale = ((1.0 + eigenvalues) ** power - 1.0) / eigenvalues
    core: Array = (axes * scale[:, None, :]) @ axes.transpose(0, 2, 1)
    return core


def low_rank_product(rows: Array, fields: Array, starts: Indices, core: Array) -> Array:
    """Multiply whitened rows by I + F C Fᵀ of their trajectory.

    Unknowns b ~ N(0, I) of one trajectory, as the zero of its force sensor, change its whitened rows by F b. The core
    of power -1/2 marginalises them: the squares of the rows returned sum to the deviance. Power 1/2 undoes that.

    Parameters
    ----------
    rows : (n, k, c)
        Whitened wrenches of k components, c columns side by side.
    fields : (n, k, r)
        F, as in `low_rank_core`.
    starts : (t,)
        First row of each trajectory.
    core : (t, r, r)
        C, from `low_rank_core`.
    """
    flat, directions = rows.reshape(-1, rows.shape[2]), fields.reshape(-1, fields.shape[2])
    parts = zip(_parts(flat, fields, starts), _parts(directions, fields, starts), core, strict=True)
    changed = [part + way @ (middle @ (way.T @ part)) for part, way, middle in parts]
    return np.concatenate(changed).reshape(rows.shape)


def _parts(flat: Array, fields: Array, starts: Indices) -> list[Array]:
    """Rows (n k, ...) of each trajectory, the k components of a frame one after the other."""
    return np.split(flat, fields.shape[1] * np.asarray(starts)[1:])
