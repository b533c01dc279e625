"""Nodal forces of a deformed neo-Hookean pad, each deformation on a thread of its own."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from numba import njit

from tactiledata.arrays import Array, Indices
from tactiledata.gel.elasticity.stiffening import Stiffening
from tactiledata.gel.mesh.cells import CellQuadrature
from tactiledata.gel.mesh.pad import PadMesh

NEO_HOOKEAN = Stiffening()
LEAST_VOLUME_RATIO = 1e-3
"""A quadrature point that is squeezed further is treated as squeezed to this, so that a wild iterate stays finite."""


@dataclass(frozen=True)
class ElasticPad:
    """What the forces of a mesh need.

    Parameters
    ----------
    cells : (c, n)
    gradients : (c, n, 3, q), weights : (c, q)
        See ``CellQuadrature``, the points last.
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
        gradients = np.ascontiguousarray(quadrature.gradients.transpose(0, 2, 3, 1))
        return ElasticPad(np.ascontiguousarray(mesh.cells), gradients, quadrature.weights, starts, places)


def internal_forces(
    pad: ElasticPad,
    displacement: Array,
    poisson_ratio: float,
    threads: Executor | None = None,
    stiffening: Stiffening = NEO_HOOKEAN,
) -> Array:
    """Forces (b, v, 3), m^2, that deformations (b, v, 3) need at the nodes, for a Young's modulus of 1.

    The energy of a cell is that of ``GelMaterial`` with the change of volume J replaced by its mean over the cell
    (Simo, Taylor and Pister, Comput. Methods Appl. Mech. Eng. 51, 1985): F becomes (mean J / J)^(1/3) F.
    """
    shear = 1.0 / (2.0 * (1.0 + poisson_ratio))
    lame = poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio))
    c20, c30 = (0.5 * shear * ratio for ratio in (stiffening.c20, stiffening.c30))
    forces = np.empty_like(displacement)

    def one(item: int) -> None:
        by_cell = np.empty((pad.cells.size, 3))
        _cell_forces(displacement[item], pad.cells, pad.gradients, pad.weights, shear, lame, c20, c30, by_cell)
        _gather(by_cell, pad.starts, pad.places, forces[item])

    each: Iterable[None] = (map if threads is None else threads.map)(one, range(len(displacement)))
    deque(each, maxlen=0)
    return forces


@njit(nogil=True, cache=True)
def _gather(by_cell: Array, starts: Indices, places: Indices, forces: Array) -> None:
    for node in range(len(forces)):
        for axis in range(3):
            total = 0.0
            for place in range(starts[node], starts[node + 1]):
                total += by_cell[places[place], axis]
            forces[node, axis] = total


@njit(nogil=True, cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"})
def _cell_forces(
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
    """Forces of each cell on its nodes; the innermost loops run over a cell's points, so that they are vectorised."""
    nodes, points = gradients.shape[1], gradients.shape[3]
    is_stiffening = c20 != 0.0 or c30 != 0.0
    f, stress = np.empty((9, points)), np.empty((9, points))
    ratios, squares, roots = np.empty(points), np.empty(points), np.empty(points)
    for cell in range(len(cells)):
        gradient, weight = gradients[cell], weights[cell]
        f[:] = 0.0
        for node in range(nodes):
            moved = displacement[cells[cell, node]]
            for i in range(3):
                for a in range(3):
                    row, slope = f[3 * i + a], gradient[node, a]
                    for q in range(points):
                        row[q] += moved[i] * slope[q]
        volume = mean_ratio = 0.0
        least = most = 1.0
        for q in range(points):
            f[0, q] += 1.0
            f[4, q] += 1.0
            f[8, q] += 1.0
            # the cofactor of F, which is d(ratio)/dF
            stress[0, q] = f[4, q] * f[8, q] - f[5, q] * f[7, q]
            stress[1, q] = f[5, q] * f[6, q] - f[3, q] * f[8, q]
            stress[2, q] = f[3, q] * f[7, q] - f[4, q] * f[6, q]
            stress[3, q] = f[2, q] * f[7, q] - f[1, q] * f[8, q]
            stress[4, q] = f[0, q] * f[8, q] - f[2, q] * f[6, q]
            stress[5, q] = f[1, q] * f[6, q] - f[0, q] * f[7, q]
            stress[6, q] = f[1, q] * f[5, q] - f[2, q] * f[4, q]
            stress[7, q] = f[2, q] * f[3, q] - f[0, q] * f[5, q]
            stress[8, q] = f[0, q] * f[4, q] - f[1, q] * f[3, q]
            ratio = f[0, q] * stress[0, q] + f[1, q] * stress[1, q] + f[2, q] * stress[2, q]
            ratios[q] = max(ratio, LEAST_VOLUME_RATIO)
            least, most = min(least, ratios[q]), max(most, ratios[q])
            volume += weight[q]
            mean_ratio += weight[q] * ratio
            square = 0.0
            for k in range(9):
                square += f[k, q] * f[k, q]
            squares[q] = square
        mean_ratio = max(mean_ratio / volume, LEAST_VOLUME_RATIO)
        if least > 0.6 and most < 1.5:
            # ratio ** (-2 / 3) by Newton's method, which is vectorised; four steps are exact in this range
            for q in range(points):
                off = ratios[q] - 1.0
                root = 1.0 - off * (1.0 / 3.0) + off * off * (2.0 / 9.0)
                for _ in range(4):
                    root *= (4.0 - ratios[q] * root * root * root) * (1.0 / 3.0)
                roots[q] = root * root
        else:
            for q in range(points):
                roots[q] = ratios[q] ** (-2.0 / 3.0)
        # derivative of the energy with respect to the mean change of volume, per volume
        pressure = 0.0
        for q in range(points):
            pressure += weight[q] * roots[q] * squares[q]
        root = mean_ratio ** (-1.0 / 3.0)
        pressure *= shear / (3.0 * volume) * root
        pressure += (lame * np.log(mean_ratio) - shear) / mean_ratio
        for q in range(points):
            scale = shear * mean_ratio * root * roots[q]
            if is_stiffening:
                strain = roots[q] * squares[q] - 3.0
                scale += 2.0 * (2.0 * c20 + 3.0 * c30 * strain) * strain * roots[q]
            along = (pressure - scale * squares[q] / (3.0 * ratios[q])) * weight[q]
            scale *= weight[q]
            for k in range(9):
                stress[k, q] = scale * f[k, q] + along * stress[k, q]
        for node in range(nodes):
            for i in range(3):
                force = 0.0
                for a in range(3):
                    row, slope = stress[3 * i + a], gradient[node, a]
                    for q in range(points):
                        force += row[q] * slope[q]
                out[cell * nodes + node, i] = force
