"""Tangent stiffness of a deformed pad: the derivative of its nodal forces at finite strain."""

from __future__ import annotations

import numpy as np
from numba import njit
from scipy.sparse import csc_array

from tactiledata.arrays import Array, Indices
from tactiledata.gel.elasticity.internal_forces import LEAST_VOLUME_RATIO, NEO_HOOKEAN, ElasticPad
from tactiledata.gel.elasticity.stiffening import Stiffening

STRAINED = 0.05
"""Largest entry of the displacement gradient up to which a cell's tangent is surely positive semi-definite."""


class TangentAssembly:
    """Assembly of the tangent stiffness for the free degrees of freedom, with the sparsity worked out once.

    Parameters
    ----------
    elastic : ElasticPad
        Cells of a mesh of v nodes.
    free : (n,)
        Degrees of freedom (three a node) that are not held.
    poisson_ratio : float
        Below 0.5.
    stiffening : Stiffening
        Yeoh's terms of the law.
    """

    def __init__(
        self, elastic: ElasticPad, free: Indices, poisson_ratio: float, stiffening: Stiffening = NEO_HOOKEAN
    ) -> None:
        self._elastic, self._stiffening = elastic, stiffening
        self._shear = 1.0 / (2.0 * (1.0 + poisson_ratio))
        self._lame = poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio))
        self._size = len(free)
        # place of each entry of the cells' matrices in the sparse matrix; the last place takes what is held
        unknown = np.full(3 * (len(elastic.starts) - 1), -1, dtype=np.int64)
        unknown[free] = np.arange(len(free))
        freedoms = unknown[(3 * elastic.cells[:, :, None] + np.arange(3)).reshape(len(elastic.cells), -1)]
        rows, columns = np.broadcast_arrays(freedoms[:, :, None], freedoms[:, None, :])
        keys = np.where((rows >= 0) & (columns >= 0), columns * self._size + rows, self._size**2).ravel()
        entries, self._places = np.unique(keys, return_inverse=True)
        entries = entries[entries < self._size**2]
        self._count = len(entries)
        self._rows = (entries % self._size).astype(np.int32)
        self._starts = np.searchsorted(entries, np.arange(self._size + 1) * self._size).astype(np.int32)

    def matrix(self, displacement: Array, is_filtered: bool = False) -> csc_array:
        """Tangent stiffness (n, n), m, at displacements (v, 3), m, for a Young's modulus of 1.

        Parameters
        ----------
        displacement : (v, 3) m
            Displacements of all nodes.
        is_filtered : bool
            Whether negative eigenvalues of a cell's matrix are replaced by zero, so that the sum is positive definite
            (Teran et al., Robust Quasistatic Finite Elements, Symposium on Computer Animation, 2005).
        """
        elastic = self._elastic
        size = 3 * elastic.cells.shape[1]
        matrices = np.empty((len(elastic.cells), size, size))
        c20, c30 = (0.5 * self._shear * ratio for ratio in (self._stiffening.c20, self._stiffening.c30))
        _cell_tangents(
            displacement, elastic.cells, elastic.gradients, elastic.weights, self._shear, self._lame, c20, c30, matrices
        )
        if is_filtered:
            _filter(matrices, displacement[elastic.cells], elastic.gradients)
        values = np.bincount(self._places, matrices.ravel(), minlength=self._count)[: self._count]
        return csc_array((values, self._rows, self._starts), shape=(self._size, self._size))


def _filter(matrices: Array, displacement: Array, gradients: Array) -> None:
    """Make the matrices (c, 3 n, 3 n) of strained cells positive semi-definite, in place."""
    slopes = np.einsum("cni,cnaq->cqia", displacement, gradients, optimize=True)
    strained = np.flatnonzero(np.abs(slopes).max(axis=(1, 2, 3)) > STRAINED)
    values, vectors = np.linalg.eigh(matrices[strained])
    negative = values[:, 0] < 0
    values, vectors = np.maximum(values[negative], 0.0), vectors[negative]
    matrices[strained[negative]] = (vectors * values[:, None, :]) @ vectors.transpose(0, 2, 1)


@njit(nogil=True, cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"})
def add_displacement_gradient(displacement: Array, nodes: Indices, gradient: Array, out: Array) -> None:
    """Add the displacement gradient at the points of a cell to ``out`` (9, q), row by row of the gradient.

    Parameters
    ----------
    displacement : (v, 3) m
        Displacements of all nodes.
    nodes : (n,)
        Nodes of the cell.
    gradient : (n, 3, q) 1/m
        Gradients of the shape functions at the points.
    out : (9, q)
        Changed in place.
    """
    for node in range(len(nodes)):
        node_displacement = displacement[nodes[node]]
        for i in range(3):
            for a in range(3):
                row, slope = out[3 * i + a], gradient[node, a]
                for q in range(len(slope)):
                    row[q] += node_displacement[i] * slope[q]


@njit(nogil=True, cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"})
def _cell_tangents(
    displacement: Array,
    cells: Indices,
    gradients: Array,
    weights: Array,
    shear: float,
    lame: float,
    c20: float,
    c30: float,
    out: Array,
) -> None:
    """Write the second derivatives (c, 3 n, 3 n), m, of the cells' energies with respect to the nodes' displacements.

    The energy of a cell is the sum over its points of w (k I + Yeoh's terms of I) plus a function of the mean volume
    ratio, where I = J^(-2/3) |F|^2 and k = shear / 2 times the mean ratio to the power of 2/3.
    """
    nodes, points = gradients.shape[1], gradients.shape[3]
    f, cofactor, slope = np.empty((points, 9)), np.empty((points, 9)), np.empty((points, 9))
    ratios, invariants, roots = np.empty(points), np.empty(points), np.empty(points)
    deformation = np.empty((9, points))
    second = np.empty((9, 9))
    half = np.empty((9, 3))
    mean_slope, invariant_slope = np.empty(3 * nodes), np.empty(3 * nodes)
    for cell in range(len(cells)):
        matrix = out[cell]
        matrix[:] = 0.0
        deformation[:] = 0.0
        deformation[0] = deformation[4] = deformation[8] = 1.0
        add_displacement_gradient(displacement, cells[cell], gradients[cell], deformation)
        volume = mean_ratio = total = 0.0
        for q in range(points):
            g = f[q]
            for k in range(9):
                g[k] = deformation[k, q]
            square = 0.0
            for i in range(3):
                j, k = (i + 1) % 3, (i + 2) % 3
                for a in range(3):
                    b, c = (a + 1) % 3, (a + 2) % 3
                    cofactor[q, 3 * i + a] = g[3 * j + b] * g[3 * k + c] - g[3 * j + c] * g[3 * k + b]
                    square += g[3 * i + a] * g[3 * i + a]
            ratio = g[0] * cofactor[q, 0] + g[1] * cofactor[q, 1] + g[2] * cofactor[q, 2]
            volume += weights[cell, q]
            mean_ratio += weights[cell, q] * ratio
            ratios[q] = max(ratio, LEAST_VOLUME_RATIO)
            roots[q] = ratios[q] ** (-2.0 / 3.0)
            invariants[q] = roots[q] * square
            total += weights[cell, q] * invariants[q]
            for k in range(9):
                slope[q, k] = 2.0 * roots[q] * (g[k] - square / (3.0 * ratios[q]) * cofactor[q, k])
        mean_ratio = max(mean_ratio / volume, LEAST_VOLUME_RATIO)
        # first and second derivative of the energy with respect to the mean ratio
        log = np.log(mean_ratio)
        pressure = shear / 3.0 * mean_ratio ** (-1.0 / 3.0) * total / volume + (lame * log - shear) / mean_ratio
        bulk = volume * (shear + lame - lame * log) / mean_ratio**2
        bulk -= shear / 9.0 * mean_ratio ** (-4.0 / 3.0) * total
        coupling = shear / 3.0 * mean_ratio ** (-1.0 / 3.0)
        mean_slope[:] = 0.0
        invariant_slope[:] = 0.0
        for q in range(points):
            weight, g, h, s = weights[cell, q], f[q], cofactor[q], slope[q]
            strain = invariants[q] - 3.0
            factor = 0.5 * shear * mean_ratio ** (2.0 / 3.0) + (2.0 * c20 + 3.0 * c30 * strain) * strain
            curvature = 2.0 * c20 + 6.0 * c30 * strain
            square = invariants[q] / roots[q]
            scale = factor * roots[q] * weight
            first = -4.0 / 3.0 / ratios[q] * scale
            both = 10.0 / 9.0 * square / (ratios[q] * ratios[q]) * scale
            for k in range(9):
                for m in range(9):
                    value = first * (g[k] * h[m] + h[k] * g[m]) + both * h[k] * h[m]
                    second[k, m] = value + weight * curvature * s[k] * s[m]
                second[k, k] += 2.0 * scale
            # the second derivative of J: entries of F with alternating signs
            turn = weight * pressure - 2.0 / 3.0 * square / ratios[q] * scale
            for i in range(3):
                for j in range(3):
                    if i == j:
                        continue
                    k = 3 - i - j
                    sign = 1.0 if (j - i) % 3 == 1 else -1.0
                    for a in range(3):
                        for b in range(3):
                            if a == b:
                                continue
                            c = 3 - a - b
                            other = 1.0 if (b - a) % 3 == 1 else -1.0
                            second[3 * i + a, 3 * j + b] += turn * sign * other * g[3 * k + c]
            for column in range(nodes):
                g0, g1, g2 = gradients[cell, column, 0, q], gradients[cell, column, 1, q], gradients[cell, column, 2, q]
                for j in range(3):
                    mean_slope[3 * column + j] += (
                        weight / volume * (h[3 * j] * g0 + h[3 * j + 1] * g1 + h[3 * j + 2] * g2)
                    )
                    invariant_slope[3 * column + j] += weight * (s[3 * j] * g0 + s[3 * j + 1] * g1 + s[3 * j + 2] * g2)
                    for k in range(9):
                        half[k, j] = second[k, 3 * j] * g0 + second[k, 3 * j + 1] * g1 + second[k, 3 * j + 2] * g2
                for row in range(column + 1):
                    n0, n1, n2 = gradients[cell, row, 0, q], gradients[cell, row, 1, q], gradients[cell, row, 2, q]
                    for i in range(3):
                        for j in range(3):
                            matrix[3 * row + i, 3 * column + j] += (
                                n0 * half[3 * i, j] + n1 * half[3 * i + 1, j] + n2 * half[3 * i + 2, j]
                            )
        for column in range(3 * nodes):
            for row in range(column + 1):
                matrix[row, column] += coupling * (
                    mean_slope[row] * invariant_slope[column] + invariant_slope[row] * mean_slope[column]
                )
                matrix[row, column] += bulk * mean_slope[row] * mean_slope[column]
                matrix[column, row] = matrix[row, column]
