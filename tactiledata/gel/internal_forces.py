"""Nodal forces of a deformed neo-Hookean pad, many deformations at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from tactiledata.gel.cells import CellQuadrature
from tactiledata.gel.pad import PadMesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

LEAST_VOLUME_RATIO = 1e-3
"""A quadrature point that is squeezed further is treated as squeezed to this, so that a wild iterate stays finite."""


@dataclass(frozen=True)
class ElasticPad:
    """What the forces of a mesh need.

    Parameters
    ----------
    cells : (c, n)
    gradients : (c, q, n, 3), weights : (c, q)
        See ``CellQuadrature``.
    starts, places : (v + 1,), (c n,)
        The entries of each node in the flattened cells: ``places[starts[i]:starts[i + 1]]``.
    """

    cells: Indices
    gradients: Array
    weights: Array
    starts: Indices
    places: Indices

    @staticmethod
    def of(mesh: PadMesh, quadrature: CellQuadrature) -> ElasticPad:
        """Gather what belongs to a mesh."""
        flat = mesh.cells.ravel()
        counts = np.bincount(flat, minlength=len(mesh.vertices))
        starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        places = np.argsort(flat, kind="stable").astype(np.int64)
        return ElasticPad(np.ascontiguousarray(mesh.cells), quadrature.gradients, quadrature.weights, starts, places)


def internal_forces(pad: ElasticPad, displacement: Array, poisson_ratio: float) -> Array:
    """Forces (b, v, 3), m^2, that deformations (b, v, 3) need at the nodes, for a Young's modulus of 1.

    The energy of a cell is that of ``GelMaterial`` with the change of volume J replaced by its mean over the cell
    (Simo, Taylor and Pister, Comput. Methods Appl. Mech. Eng. 51, 1985): F becomes (mean J / J)^(1/3) F.
    """
    shear = 1.0 / (2.0 * (1.0 + poisson_ratio))
    lame = poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio))
    count, nodes = displacement.shape[0], pad.cells.shape[1]
    by_cell = np.empty((count, len(pad.cells) * nodes, 3))
    _cell_forces(displacement, pad.cells, pad.gradients, pad.weights, shear, lame, by_cell)
    forces = np.empty_like(displacement)
    _gather(by_cell, pad.starts, pad.places, forces)
    return forces


@njit(parallel=True, cache=True)
def _gather(by_cell: Array, starts: Indices, places: Indices, forces: Array) -> None:
    batch, nodes = forces.shape[0], forces.shape[1]
    for item in prange(batch * nodes):
        b, node = item // nodes, item % nodes
        for axis in range(3):
            total = 0.0
            for place in range(starts[node], starts[node + 1]):
                total += by_cell[b, places[place], axis]
            forces[b, node, axis] = total


@njit(parallel=True, cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"})
def _cell_forces(
    displacement: Array, cells: Indices, gradients: Array, weights: Array, shear: float, lame: float, out: Array
) -> None:
    batch, count = displacement.shape[0], cells.shape[0]
    points, nodes = gradients.shape[1], gradients.shape[2]
    for item in prange(batch * count):
        b, cell = item // count, item % count
        deformation = np.empty((points, 9))
        squares = np.empty(points)
        ratios = np.empty(points)
        volume = 0.0
        mean_ratio = 0.0
        for q in range(points):
            f = deformation[q]
            f[:] = 0.0
            f[0] = f[4] = f[8] = 1.0
            for node in range(nodes):
                moved = displacement[b, cells[cell, node]]
                g0, g1, g2 = gradients[cell, q, node]
                for i in range(3):
                    f[3 * i] += moved[i] * g0
                    f[3 * i + 1] += moved[i] * g1
                    f[3 * i + 2] += moved[i] * g2
            ratio = (
                f[0] * (f[4] * f[8] - f[5] * f[7])
                - f[1] * (f[3] * f[8] - f[5] * f[6])
                + f[2] * (f[3] * f[7] - f[4] * f[6])
            )
            square = 0.0
            for k in range(9):
                square += f[k] * f[k]
            squares[q] = square
            ratios[q] = max(ratio, LEAST_VOLUME_RATIO)
            volume += weights[cell, q]
            mean_ratio += weights[cell, q] * ratio
        mean_ratio = max(mean_ratio / volume, LEAST_VOLUME_RATIO)
        # derivative of the energy with respect to the mean change of volume, per volume
        pressure = 0.0
        for q in range(points):
            pressure += weights[cell, q] * ratios[q] ** (-2.0 / 3.0) * squares[q]
        pressure *= shear / (3.0 * volume) * mean_ratio ** (-1.0 / 3.0)
        pressure += (lame * np.log(mean_ratio) - shear) / mean_ratio
        forces = out[b, cell * nodes : (cell + 1) * nodes]
        forces[:] = 0.0
        stress = np.empty(9)
        for q in range(points):
            f = deformation[q]
            scale = shear * (mean_ratio / ratios[q]) ** (2.0 / 3.0)
            # d(ratio)/dF is the cofactor of F
            along = pressure - scale * squares[q] / (3.0 * ratios[q])
            stress[0] = scale * f[0] + along * (f[4] * f[8] - f[5] * f[7])
            stress[1] = scale * f[1] + along * (f[5] * f[6] - f[3] * f[8])
            stress[2] = scale * f[2] + along * (f[3] * f[7] - f[4] * f[6])
            stress[3] = scale * f[3] + along * (f[2] * f[7] - f[1] * f[8])
            stress[4] = scale * f[4] + along * (f[0] * f[8] - f[2] * f[6])
            stress[5] = scale * f[5] + along * (f[1] * f[6] - f[0] * f[7])
            stress[6] = scale * f[6] + along * (f[1] * f[5] - f[2] * f[4])
            stress[7] = scale * f[7] + along * (f[2] * f[3] - f[0] * f[5])
            stress[8] = scale * f[8] + along * (f[0] * f[4] - f[1] * f[3])
            stress *= weights[cell, q]
            for node in range(nodes):
                g0, g1, g2 = gradients[cell, q, node]
                for i in range(3):
                    forces[node, i] += stress[3 * i] * g0 + stress[3 * i + 1] * g1 + stress[3 * i + 2] * g2
