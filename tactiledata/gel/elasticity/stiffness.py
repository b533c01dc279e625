"""Linear stiffness matrix of a pad, with the dilatation averaged over each cell so that it does not lock."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csr_array

from tactiledata.gel.mesh.cells import CellQuadrature
from tactiledata.gel.mesh.pad import PadMesh


def linear_stiffness(mesh: PadMesh, quadrature: CellQuadrature, poisson_ratio: float) -> csr_array:
    """Assemble the stiffness matrix (3 v, 3 v), m, of a pad whose Young's modulus is 1.

    The change of volume is averaged over each cell (Nagtegaal, Parks and Rice, Comput. Methods Appl. Mech. Eng. 4,
    1974). The matrix is the tangent of ``internal_forces`` at rest. Its rows and columns are x, y and z of the first
    node, then of the second, and so on. No node is held: those of the base, too, are free.

    Parameters
    ----------
    mesh : PadMesh
        Gives the nodes of each cell; v nodes in all.
    quadrature : CellQuadrature
        Gradients of shape functions and weights.
    poisson_ratio : float
        Below 0.5.
    """
    shear = 1.0 / (2.0 * (1.0 + poisson_ratio))
    lame = poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio))
    gradients, weights, volumes = quadrature.gradients, quadrature.weights, quadrature.volumes
    nodes = gradients.shape[2]
    weighted = gradients * weights[:, :, None, None]
    # (c, n, 3, m, 3): sum over the quadrature points of w dN_a/dx_i dN_b/dx_j
    flat = gradients.reshape(*gradients.shape[:2], -1)
    products = np.matmul(weighted.reshape(flat.shape).transpose(0, 2, 1), flat)
    products = products.reshape(-1, nodes, 3, nodes, 3)
    # deviatoric part of each cell's stiffness
    cells = shear * products.transpose(0, 1, 4, 3, 2) - (2.0 / 3.0) * shear * products
    laplacian = shear * np.einsum("caibi->cab", products)
    for axis in range(3):
        cells[:, :, axis, :, axis] += laplacian
    # volumetric part, with the mean dilatation
    mean = weighted.sum(axis=1).reshape(len(volumes), -1) / volumes[:, None]
    bulk = (lame + 2.0 * shear / 3.0) * volumes[:, None, None] * mean[:, :, None] * mean[:, None, :]
    cells = cells.reshape(len(volumes), 3 * nodes, 3 * nodes) + bulk
    # assembly: entries of the same pair of unknowns add up
    freedoms = (3 * mesh.cells[:, :, None] + np.arange(3)).reshape(len(volumes), -1)
    rows = np.repeat(freedoms, 3 * nodes, axis=1).ravel()
    columns = np.tile(freedoms, (1, 3 * nodes)).ravel()
    size = 3 * len(mesh.vertices)
    return csr_array(coo_array((cells.ravel(), (rows, columns)), shape=(size, size)))
