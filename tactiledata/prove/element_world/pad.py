"""A pad of nearly incompressible neo-Hookean bricks whose volume is counted by its mean over each brick."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, ElementHex1, FacetBasis, MeshHex

Array = NDArray[Any]
Rows = NDArray[np.intp]

_SIGNS = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _SIGNS[_i, _j, _k], _SIGNS[_i, _k, _j] = 1.0, -1.0
_SECOND = np.einsum("ikm,jln->ijklmn", _SIGNS, _SIGNS).reshape(81, 9)
"""Derivative (81, 9) of the cofactors of a matrix with respect to it, times the matrix (9,)."""


@dataclass(frozen=True)
class BrickForces:
    """Internal forces of the bricks, and how they change.

    Parameters
    ----------
    force : (e, 8, 3)
        BrickForces of each brick on its nodes, mm².
    stiffness : (e, 8, 3, 8, 3)
        Their derivative by displacements, mm.
    """

    force: Array
    stiffness: Array


class BrickPad:
    """Bricks between grid lines, bonded below, free on all other sides.

    Parameters
    ----------
    lines : three arrays, mm
        Grid lines along x, y and z; z ends at the outer surface, 0.
    poisson_ratio : float
        Below 0.5.
    """

    def __init__(self, lines: tuple[Array, Array, Array], poisson_ratio: float) -> None:
        self.lines = lines
        self.shear = 0.5 / (1.0 + poisson_ratio)
        self.bulk = 1.0 / (3.0 * (1.0 - 2.0 * poisson_ratio))
        mesh = MeshHex.init_tensor(*lines)
        basis = Basis(mesh, ElementHex1(), intorder=3)
        fields = [field[0] for field in basis.basis]
        # gradients (e, q, 8, 3) and weights (e, q)
        self._gradients = np.ascontiguousarray(np.stack([f.grad for f in fields]).transpose(2, 3, 0, 1))
        self._weights = np.asarray(basis.dx)
        self.volumes = self._weights.sum(axis=1)
        # nodes are counted along z, then along the second axis, slice by slice
        places = basis.doflocs
        self.axis = 0 if len(lines[0]) >= len(lines[1]) else 1
        order = np.lexsort((places[2].round(9), places[1 - self.axis].round(9), places[self.axis].round(9)))
        number = np.empty(len(order), dtype=np.intp)
        number[order] = np.arange(len(order))
        self.places = places[:, order].T.copy()
        self.bricks: Rows = number[basis.element_dofs.T]
        self.is_bonded = self.places[:, 2] < lines[2][0] + 1e-9
        # points of contact on the outer surface: shares (f, p, 4) of the corners of each facet
        top = mesh.facets_satisfying(lambda x: np.abs(x[2] - lines[2][-1]) < 1e-9, boundaries_only=True)
        surface = FacetBasis(mesh, ElementHex1(), facets=top, intorder=7)
        values = np.stack([np.broadcast_to(np.asarray(field[0]), surface.dx.shape) for field in surface.basis], axis=2)
        self.brick_of_facet: Rows = np.asarray(surface.tind, dtype=np.intp)
        inside = values.max(axis=1) > 1e-9
        self.corners: Rows = np.array([np.flatnonzero(row) for row in inside])
        self.shares = np.take_along_axis(values, self.corners[:, None, :], axis=2)
        self.areas = np.asarray(surface.dx)
        self.facets = np.take_along_axis(self.bricks[self.brick_of_facet], self.corners, axis=1)

    def smallest_volume(self, displacements: Array) -> float:
        """Return the smallest ratio of volume to that at rest, at any point, under displacements (n, 3)."""
        return float(np.linalg.det(self._deformation(displacements)).min())

    def _deformation(self, displacements: Array) -> Array:
        moved = displacements[self.bricks]
        return np.eye(3) + np.matmul(moved.transpose(0, 2, 1)[:, None], self._gradients)

    def respond(self, displacements: Array, with_stiffness: bool = True) -> BrickForces:
        """Return the bricks' forces under displacements (n, 3), mm.

        The energy is ``G/2 (J^(-2/3) I1 - 3)`` at each point and ``K/4 (t² - 1 - 2 ln t)`` of the mean ratio of
        volumes t of a brick.
        """
        gradients, weights = self._gradients, self._weights
        f = self._deformation(displacements)
        h = np.cross(f[..., [1, 2, 0], :], f[..., [2, 0, 1], :])
        j = np.einsum("eqi,eqi->eq", f[..., 0, :], h[..., 0, :])
        first = np.einsum("eqij,eqij->eq", f, f)
        mean = (weights * j).sum(axis=1) / self.volumes
        pressure = 0.5 * self.bulk * (mean - 1.0 / mean)
        a, s = self.shear * j ** (-2.0 / 3.0), 1.0 / j
        on_cofactors = pressure[:, None] - a * first * s / 3.0
        stress = a[..., None, None] * f + on_cofactors[..., None, None] * h
        # both weighed: forces (e, 8, 3)
        weighed = gradients * weights[..., None, None]
        force = np.einsum("eqai,eqji->eaj", weighed, stress, optimize=True)
        if not with_stiffness:
            return BrickForces(force, np.zeros((0, 8, 3, 8, 3)))
        # a derivative in single precision is enough for corrections
        count, single = len(f), np.float32
        f, h, a, s, first, on_cofactors, gradients, weighed = (
            part.astype(single) for part in (f, h, a, s, first, on_cofactors, gradients, weighed)
        )
        flat_f, flat_h = f.reshape(count, 8, 9), h.reshape(count, 8, 9)
        d = on_cofactors[..., None] * (flat_f @ _SECOND.T.astype(single))
        d = d.reshape(count, 8, 9, 9)
        d[..., range(9), range(9)] += a[..., None]
        mixed = (single(-2 / 3) * a * s)[..., None] * flat_f + (single(5 / 18) * a * s * s * first)[..., None] * flat_h
        product = mixed[..., :, None] * flat_h[..., None, :]
        d += product
        d += product.transpose(0, 1, 3, 2)
        # (i, j, k, l): contract l, then j and the points
        right = np.matmul(d.reshape(count, 8, 27, 3), gradients.transpose(0, 1, 3, 2))
        right = right.reshape(count, 8, 3, 3, 24).transpose(0, 1, 3, 2, 4).reshape(count, 24, 72)
        left = weighed.transpose(0, 2, 1, 3).reshape(count, 8, 24)
        stiffness = np.matmul(left, right).reshape(count, 8, 3, 3, 8).transpose(0, 1, 2, 4, 3).copy()
        volume = np.einsum("eqai,eqji->eaj", weighed, h, optimize=True).reshape(count, 24)
        rate = 0.5 * self.bulk * (1.0 + 1.0 / mean**2) / self.volumes
        rate = rate.astype(single)
        stiffness += ((rate[:, None] * volume)[:, :, None] * volume[:, None, :]).reshape(stiffness.shape)
        return BrickForces(force, stiffness)
