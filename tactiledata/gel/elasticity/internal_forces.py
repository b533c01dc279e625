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
LANES = 64
"""Cells of a group, whose numbers stand side by side so that a processor takes several at once.

With fewer, the loops over a group are too short; with more, a group no longer fits the processor's nearest cache."""
SMALL = (0.6, 1.5)
"""Volume ratios between which Newton's method finds the root, which is quicker than a power."""


@dataclass(frozen=True)
class ElasticPad:
    """Arrays of a mesh from which nodal forces and their derivatives are computed.

    Parameters
    ----------
    cells : (c, n)
        Nodes of each cell.
    gradients : (c, n, 3, q) 1/m, weights : (c, q) m^3
        As in ``CellQuadrature``, with the q points last.
    group_cells : (g, n, ``LANES``)
        ``cells`` in groups; the last cell fills up the last group.
    group_gradients : (g, n, 3, q, ``LANES``) 1/m, group_weights : (g, q, ``LANES``) m^3
        The same of ``gradients`` and ``weights``.
    starts, places : (v + 1,), (c n,)
        Entries of node i in the flattened ``group_cells``: ``places[starts[i]:starts[i + 1]]``.
    """

    cells: Indices
    gradients: Array
    weights: Array
    group_cells: Indices
    group_gradients: Array
    group_weights: Array
    starts: Indices
    places: Indices

    @staticmethod
    def of(mesh: PadMesh, quadrature: CellQuadrature) -> ElasticPad:
        """Return the arrays of a mesh and its quadrature."""
        cells = np.ascontiguousarray(mesh.cells)
        gradients = np.ascontiguousarray(quadrature.gradients.transpose(0, 2, 3, 1))
        count, nodes = cells.shape
        groups = -(-count // LANES)
        members = np.minimum(np.arange(groups * LANES), count - 1).reshape(groups, LANES)
        # the entries of each node, in the order of the cells
        flat = cells.ravel()
        starts = np.concatenate([[0], np.cumsum(np.bincount(flat, minlength=len(mesh.vertices)))]).astype(np.int64)
        order = np.argsort(flat, kind="stable").astype(np.int64)
        cell, node = order // nodes, order % nodes
        return ElasticPad(
            cells,
            gradients,
            quadrature.weights,
            np.ascontiguousarray(cells[members].transpose(0, 2, 1)),
            np.ascontiguousarray(gradients[members].transpose(0, 2, 3, 4, 1)),
            np.ascontiguousarray(quadrature.weights[members].transpose(0, 2, 1)),
            starts,
            (cell // LANES * nodes + node) * LANES + cell % LANES,
        )


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
        cell_forces = np.empty((3, *pad.group_cells.shape))
        _group_forces(
            displacement[item], pad.group_cells, pad.group_gradients, pad.group_weights, shear, lame, c20, c30,
            cell_forces,
        )  # fmt: skip
        _gather(cell_forces.reshape(3, -1), pad.starts, pad.places, forces[item])

    work: Iterable[None] = (map if threads is None else threads.map)(forces_of_item, range(len(displacement)))
    deque(work, maxlen=0)
    return forces


@njit(nogil=True, cache=True)
def _gather(cell_forces: Array, starts: Indices, places: Indices, forces: Array) -> None:
    """Sum the cells' forces (3, g n ``LANES``) on each node into ``forces`` (v, 3), always in the same order."""
    for node in range(len(forces)):
        for axis in range(3):
            total = 0.0
            for place in range(starts[node], starts[node + 1]):
                total += cell_forces[axis, places[place]]
            forces[node, axis] = total


@njit(nogil=True, cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"})
def _group_forces(
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
    """Write the forces of each cell on its nodes to ``out`` (3, g, n, ``LANES``), m^2.

    The innermost loops run over the cells of a group, so that they are vectorised.
    """
    groups, nodes, _, points, lanes = gradients.shape
    is_stiffening = c20 != 0.0 or c30 != 0.0
    moved = np.empty((nodes, 3, lanes))
    f, stress = np.empty((points, 9, lanes)), np.empty((9, lanes))
    ratios, squares, roots = np.empty((points, lanes)), np.empty((points, lanes)), np.empty((points, lanes))
    volume, mean_ratio, pressure = np.empty(lanes), np.empty(lanes), np.empty(lanes)
    for group in range(groups):
        for node in range(nodes):
            for lane in range(lanes):
                place = cells[group, node, lane]
                for i in range(3):
                    moved[node, i, lane] = displacement[place, i]
        volume[:] = 0.0
        mean_ratio[:] = 0.0
        pressure[:] = 0.0
        least = most = 1.0
        for q in range(points):
            # deformation gradient, row by row
            f[q] = 0.0
            for lane in range(lanes):
                f[q, 0, lane] = f[q, 4, lane] = f[q, 8, lane] = 1.0
            for node in range(nodes):
                for i in range(3):
                    for lane in range(lanes):
                        f[q, 3 * i, lane] += moved[node, i, lane] * gradients[group, node, 0, q, lane]
                        f[q, 3 * i + 1, lane] += moved[node, i, lane] * gradients[group, node, 1, q, lane]
                        f[q, 3 * i + 2, lane] += moved[node, i, lane] * gradients[group, node, 2, q, lane]
            for lane in range(lanes):
                f0, f1, f2 = f[q, 0, lane], f[q, 1, lane], f[q, 2, lane]
                f3, f4, f5 = f[q, 3, lane], f[q, 4, lane], f[q, 5, lane]
                f6, f7, f8 = f[q, 6, lane], f[q, 7, lane], f[q, 8, lane]
                ratio = f0 * (f4 * f8 - f5 * f7) + f1 * (f5 * f6 - f3 * f8) + f2 * (f3 * f7 - f4 * f6)
                volume[lane] += weights[group, q, lane]
                mean_ratio[lane] += weights[group, q, lane] * ratio
                ratios[q, lane] = max(ratio, LEAST_VOLUME_RATIO)
                squares[q, lane] = (
                    f0 * f0 + f1 * f1 + f2 * f2 + f3 * f3 + f4 * f4 + f5 * f5 + f6 * f6 + f7 * f7 + f8 * f8
                )
            for lane in range(lanes):
                least, most = min(least, ratios[q, lane]), max(most, ratios[q, lane])
        is_small = least > SMALL[0] and most < SMALL[1]
        for q in range(points):
            if is_small:
                # ratio ** (-2 / 3) by Newton's method, which is vectorised; four steps reach rounding in this range
                for lane in range(lanes):
                    ratio = ratios[q, lane]
                    excess = ratio - 1.0
                    root = 1.0 - excess * (1.0 / 3.0) + excess * excess * (2.0 / 9.0)
                    root *= (4.0 - ratio * root * root * root) * (1.0 / 3.0)
                    root *= (4.0 - ratio * root * root * root) * (1.0 / 3.0)
                    root *= (4.0 - ratio * root * root * root) * (1.0 / 3.0)
                    root *= (4.0 - ratio * root * root * root) * (1.0 / 3.0)
                    roots[q, lane] = root * root
            else:
                for lane in range(lanes):
                    roots[q, lane] = ratios[q, lane] ** (-2.0 / 3.0)
            for lane in range(lanes):
                pressure[lane] += weights[group, q, lane] * roots[q, lane] * squares[q, lane]
        for lane in range(lanes):
            # derivative of the energy with respect to the mean change of volume, per volume
            mean = max(mean_ratio[lane] / volume[lane], LEAST_VOLUME_RATIO)
            root = mean ** (-1.0 / 3.0)
            pressure[lane] *= shear / (3.0 * volume[lane]) * root
            pressure[lane] += (lame * np.log(mean) - shear) / mean
            mean_ratio[lane] = shear * mean * root
        for i in range(3):
            out[i, group] = 0.0
        for q in range(points):
            for lane in range(lanes):
                # first Piola-Kirchhoff stress times the weight; the cofactor of F is d(ratio)/dF
                scale, root, square = mean_ratio[lane] * roots[q, lane], roots[q, lane], squares[q, lane]
                if is_stiffening:
                    strain = root * square - 3.0
                    scale += 2.0 * (2.0 * c20 + 3.0 * c30 * strain) * strain * root
                turn = (pressure[lane] - scale * square / (3.0 * ratios[q, lane])) * weights[group, q, lane]
                scale *= weights[group, q, lane]
                f0, f1, f2 = f[q, 0, lane], f[q, 1, lane], f[q, 2, lane]
                f3, f4, f5 = f[q, 3, lane], f[q, 4, lane], f[q, 5, lane]
                f6, f7, f8 = f[q, 6, lane], f[q, 7, lane], f[q, 8, lane]
                stress[0, lane] = scale * f0 + turn * (f4 * f8 - f5 * f7)
                stress[1, lane] = scale * f1 + turn * (f5 * f6 - f3 * f8)
                stress[2, lane] = scale * f2 + turn * (f3 * f7 - f4 * f6)
                stress[3, lane] = scale * f3 + turn * (f2 * f7 - f1 * f8)
                stress[4, lane] = scale * f4 + turn * (f0 * f8 - f2 * f6)
                stress[5, lane] = scale * f5 + turn * (f1 * f6 - f0 * f7)
                stress[6, lane] = scale * f6 + turn * (f1 * f5 - f2 * f4)
                stress[7, lane] = scale * f7 + turn * (f2 * f3 - f0 * f5)
                stress[8, lane] = scale * f8 + turn * (f0 * f4 - f1 * f3)
            # forces on the nodes: stress times the gradients of shape functions
            for node in range(nodes):
                for i in range(3):
                    for lane in range(lanes):
                        out[i, group, node, lane] += (
                            stress[3 * i, lane] * gradients[group, node, 0, q, lane]
                            + stress[3 * i + 1, lane] * gradients[group, node, 1, q, lane]
                            + stress[3 * i + 2, lane] * gradients[group, node, 2, q, lane]
                        )
