"""Gradients of shape functions and quadrature weights of the cells, on the undeformed mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.errors import UsageError
from tactiledata.gel.mesh.pad import CellKind, PadMesh

_CUBE = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float
)
_TETRAHEDRON_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))


@dataclass(frozen=True)
class CellQuadrature:
    """Gradients and weights at the q quadrature points of c cells of n nodes.

    Parameters
    ----------
    gradients : (c, q, n, 3) 1/m
        Derivatives of the shape functions with respect to the undeformed position.
    weights : (c, q) m^3
        Quadrature weight times the volume element: they sum to a cell's volume.
    """

    gradients: Array
    weights: Array

    @property
    def volumes(self) -> Array:
        """Volume (c,) of each cell, m^3."""
        volumes: Array = self.weights.sum(axis=1)
        return volumes

    def stiffened(self, factors: Array) -> CellQuadrature:
        """Return the quadrature of cells whose Young's modulus is multiplied by factors (c,).

        Forces and stiffness are linear in the weights, so the weights carry the factors.

        Raises
        ------
        UsageError
            The number of factors is not that of cells, or a factor is not positive.
        """
        if factors.shape != self.weights.shape[:1] or not (np.isfinite(factors) & (factors > 0)).all():
            raise UsageError(
                f"{factors.shape} factors on the cells' modulus, the least {factors.min(initial=np.inf):g}",
                f"{len(self.weights)} positive numbers, one for each cell",
                "Correct them.",
            )
        return CellQuadrature(self.gradients, self.weights * factors[:, None])


def cell_quadrature(mesh: PadMesh) -> CellQuadrature:
    """Return gradients of shape functions and quadrature weights of a mesh.

    Raises
    ------
    UsageError
        A cell is turned inside out or flat.
    """
    derivatives, reference_weights = _reference(mesh.kind)
    jacobian = np.einsum("qnk,cni->cqik", derivatives, mesh.vertices[mesh.cells], optimize=True)
    determinant = np.linalg.det(jacobian)
    if determinant.min() <= 0:
        worst = int(np.argmin(determinant.min(axis=1)))
        raise UsageError(
            f"cell {worst} of the mesh {mesh.name!r} is turned inside out or flat",
            "cells of positive volume",
            "Mend the mesh, or write the cell's nodes in the usual order.",
            cell=worst,
        )
    gradients = np.einsum("qnk,cqki->cqni", derivatives, np.linalg.inv(jacobian), optimize=True)
    return CellQuadrature(np.ascontiguousarray(gradients), determinant * reference_weights)


def _reference(kind: CellKind) -> tuple[Array, Array]:
    """Derivatives (q, n, 3) of the shape functions in the reference cell, and weights (q,)."""
    if kind == "hexahedron8":
        points = _CUBE / np.sqrt(3.0)
        factors = 1.0 + _CUBE[None] * points[:, None]
        derivatives = np.empty((8, 8, 3))
        for axis in range(3):
            other_axes = [index for index in range(3) if index != axis]
            derivatives[:, :, axis] = _CUBE[:, axis] * factors[:, :, other_axes].prod(axis=-1) / 8.0
        return derivatives, np.ones(8)
    # four points of equal weight; quadratic shape functions at corners and edges
    near, far = (5.0 - np.sqrt(5.0)) / 20.0, (5.0 + 3.0 * np.sqrt(5.0)) / 20.0
    barycentric = np.full((4, 4), near) + (far - near) * np.eye(4)
    barycentric_slopes = np.array([[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    corners = (4.0 * barycentric - 1.0)[:, :, None] * barycentric_slopes
    edges = np.stack(
        [
            4.0 * (barycentric[:, a, None] * barycentric_slopes[b] + barycentric[:, b, None] * barycentric_slopes[a])
            for a, b in _TETRAHEDRON_EDGES
        ],
        axis=1,
    )
    return np.concatenate([corners, edges], axis=1), np.full(4, 1.0 / 24.0)
