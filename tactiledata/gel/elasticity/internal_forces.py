"""Nodal forces of a pad at finite strain, neo-Hookean or with Yeoh's terms; deformations run on parallel threads."""

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
"""The law without further terms."""
LEAST_VOLUME_RATIO = 1e-3
"""Smallest volume ratio J: smaller values are replaced by it, so that a diverging iterate stays finite."""


@dataclass(frozen=True)
class ElasticPad:
    """Arrays of a mesh from which nodal forces are computed.

    Parameters
    ----------
    cells : (c, n)
        Nodes of each cell.
    gradients : (c, n, 3, q) 1/m, weights : (c, q) m^3
        As in ``CellQuadrature``, with the q points last.
    starts, places : (v + 1,), (c n,)
        Entries of node i in the flattened cells: ``places[starts[i]:starts[i + 1]]``.
    """

    cells: Indices
    gradients: Array
    weights: Array
    starts: Indices
    places: Indices

    @staticmethod
    def of(mesh: PadMesh, quadrature: CellQuadrature) -> ElasticPad:
        """Return the arrays of a mesh and its quadrature."""
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
    """Nodal forces (b, v, 3), m^2, that hold b deformations of a pad, for a Young's modulus of 1.

    The energy of a cell is that of ``GelMaterial`` with the volume ratio J replaced by its mean over the cell (Simo,
    Taylor and Pister, Comput. Methods Appl. Mech. Eng. 51, 1985): F becomes (mean J / J)^(1/3) F.

    Parameters
    ----------
    pad : ElasticPad
        Mesh of v nodes.
    displacement : (b, v, 3) m
        Displacements of all nodes.
    poisson_ratio : float
        Below 0.5.
    threads : Executor, optional
        Runs the b deformations in parallel; one after another by default.
    stiffening : Stiffening
        Yeoh's terms; none by default.
    """
    shear = 1.0 / (2.0 * (1.0 + poisson_ratio))
    lame = poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio))
    c20, c30 = (0.5 * shear * ratio for ratio in (stiffening.c20, stiffening.c30))
    forces = np.empty_like(displacement)

    def forces_of_item(item: int) -> None:
        """Write the nodal forces of one deformation."""
        cell_forces = np.empty((pad.cells.size, 3))
        _cell_forces(displacement[item], pad.cells, pad.gradients, pad.weights, shear, lame, c20, c30, cell_forces)
        _gather(cell_forces, pad.starts, pad.places, forces[item])

    work: Iterable[None] = (map if threads is None else threads.map)(forces_of_item, range(len(displacement)))
    deque(work, maxlen=0)
    return forces


@njit(nogil=True, cache=True)
def _gather(cell_forces: Array, starts: Indices, places: Indices, forces: Array) -> None:
    """Sum the cells' forces (c n, 3) on each node into ``forces`` (v, 3), always in the same order."""
    for node in range(len(forces)):
        for axis in range(3):
            total = 0.0
            for place in range(starts[node], starts[node + 1]):
                total += cell_forces[places[place], axis]
            forces[node, axis] = total


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
    """Write the forces of each cell on its nodes to ``out`` (c n, 3), m^2.

    The innermost loops run over a cell's points, so that they are vectorised.
    """
    nodes, points = gradients.shape[1], gradients.shape[3]
    is_stiffening = c20 != 0.0 or c30 != 0.0
    f, stress = np.empty((9, points)), np.empty((9, points))
    ratios, squares, roots = np.empty(points), np.empty(points), np.empty(points)
    for cell in range(len(cells)):
        gradient, weight = gradients[cell], weights[cell]
        # displacement gradient at the points; the identity is added below
        f[:] = 0.0
        add_displacement_gradient(displacement, cells[cell], gradient, f)
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
            # ratio ** (-2 / 3) by Newton's method, which is vectorised; four steps reach rounding in this range
            for q in range(points):
                excess = ratios[q] - 1.0
                root = 1.0 - excess * (1.0 / 3.0) + excess * excess * (2.0 / 9.0)
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
        # first Piola-Kirchhoff stress times the weight
        for q in range(points):
            scale = shear * mean_ratio * root * roots[q]
            if is_stiffening:
                strain = roots[q] * squares[q] - 3.0
                scale += 2.0 * (2.0 * c20 + 3.0 * c30 * strain) * strain * roots[q]
            pressure_factor = (pressure - scale * squares[q] / (3.0 * ratios[q])) * weight[q]
            scale *= weight[q]
            for k in range(9):
                stress[k, q] = scale * f[k, q] + pressure_factor * stress[k, q]
        # forces on the nodes: stress times the gradients of shape functions
        for node in range(nodes):
            for i in range(3):
                force = 0.0
                for a in range(3):
                    row, slope = stress[3 * i + a], gradient[node, a]
                    for q in range(points):
                        force += row[q] * slope[q]
                out[cell * nodes + node, i] = force
