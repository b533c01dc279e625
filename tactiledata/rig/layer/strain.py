"""The internal forces of the layer at large strain.

Compressible neo-Hookean: W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2.
"""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import RealArray
from tactiledata.rig.layer.grid import Column, LayerGrid
from tactiledata.rig.layer.kernel import unseen_shape

FLATTEST = 0.2
"""Volume ratio below which the logarithm is continued by its tangent, so that a bad guess has a finite force."""


class LayerStrain:
    """The elasticity of a pad: internal forces from displacements.

    Parameters
    ----------
    grid : LayerGrid
        Points in the plane.
    column : Column
        Nodes through the thickness.
    shear, lame : Pa
        Lamé's constants mu and lambda.
    is_linear : bool
        Whether strain is taken as small, for comparison.
    """

    def __init__(self, grid: LayerGrid, column: Column, shear: float, lame: float, is_linear: bool = False) -> None:
        self._column, self._pitch = column, grid.pitch
        self._shear, self._lame = shear, lame
        self._unseen = shear * unseen_shape(column, grid.pitch)
        self._areas = (grid.filling * grid.pitch**2).ravel()
        self._is_linear = is_linear

    def forces(self, u: RealArray) -> RealArray:
        """Return the nodal forces (3, levels, rows, columns), N, that hold displacements ``u`` of that shape, m."""
        # gradient of the displacements at the quadrature points
        column = self._column
        flat = (3, u.shape[1], -1)
        mean, along_x, along_y, unseen = (part.reshape(flat) for part in _to_cells(u, self._pitch))
        gradient = np.empty((3, 3, len(column.weights), mean.shape[2]))
        np.matmul(column.pick, along_x, out=gradient[:, 0])
        np.matmul(column.pick, along_y, out=gradient[:, 1])
        np.matmul(column.slope, mean, out=gradient[:, 2])
        # stress there, and the forces of the nodes
        stress = self._linear_stress(gradient) if self._is_linear else self._stress(gradient)
        stress *= column.weights[:, None] * self._areas
        return _to_nodes(
            (column.slope.T @ stress[:, 2]).reshape(u.shape),
            (column.pick.T @ stress[:, 0]).reshape(u.shape),
            (column.pick.T @ stress[:, 1]).reshape(u.shape),
            (self._unseen @ unseen * self._areas).reshape(u.shape),
            self._pitch,
        )

    def _linear_stress(self, gradient: RealArray) -> RealArray:
        """Return the stress (3, 3, points, cells), Pa, of small strain at gradients of displacement of that shape."""
        stress = self._shear * (gradient + gradient.swapaxes(0, 1))
        pressure = self._lame * (gradient[0, 0] + gradient[1, 1] + gradient[2, 2])
        for axis in range(3):
            stress[axis, axis] += pressure
        return stress

    def _stress(self, gradient: RealArray) -> RealArray:
        """Return the first Piola-Kirchhoff stress (3, 3, points, cells), Pa, at gradients of displacement."""
        f = gradient
        for axis in range(3):
            f[axis, axis] += 1.0
        cofactor = np.empty_like(f)
        for i in range(3):
            for j in range(3):
                a, b, c, d = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
                np.multiply(f[a, c], f[b, d], out=cofactor[i, j])
                cofactor[i, j] -= f[a, d] * f[b, c]
        volume = f[0, 0] * cofactor[0, 0] + f[0, 1] * cofactor[0, 1] + f[0, 2] * cofactor[0, 2]
        # d/dJ of lambda/2 (ln J)² - mu ln J
        pressure = (self._lame * _log(volume) - self._shear) / np.maximum(volume, FLATTEST)
        stress = self._shear * f
        cofactor *= pressure
        stress += cofactor
        return stress


def _log(volume: RealArray) -> RealArray:
    """Return the logarithm of the volume ratio, continued by its tangent below ``FLATTEST``."""
    inside = np.maximum(volume, FLATTEST)
    return np.log(inside) + (volume - inside) / FLATTEST


def _to_cells(u: RealArray, pitch: float) -> tuple[RealArray, RealArray, RealArray, RealArray]:
    """Return mean, slopes along x and y and alternating sum of the corners of each cell, each of the shape of ``u``."""
    wrapped = np.concatenate([u, u[:, :, :1]], axis=2)
    wrapped = np.concatenate([wrapped, wrapped[:, :, :, :1]], axis=3)
    sums = wrapped[:, :, :, 1:] + wrapped[:, :, :, :-1]
    steps = wrapped[:, :, :, 1:] - wrapped[:, :, :, :-1]
    mean = (sums[:, :, 1:] + sums[:, :, :-1]) * 0.25
    along_y = (sums[:, :, 1:] - sums[:, :, :-1]) * (0.5 / pitch)
    along_x = (steps[:, :, 1:] + steps[:, :, :-1]) * (0.5 / pitch)
    return mean, along_x, along_y, steps[:, :, 1:] - steps[:, :, :-1]


def _to_nodes(mean: RealArray, along_x: RealArray, along_y: RealArray, unseen: RealArray, pitch: float) -> RealArray:
    """Return nodal values from cell values, by the transpose of ``_to_cells``."""
    flat = mean * 0.25
    x = along_x * (0.5 / pitch)
    y = along_y * (0.5 / pitch)
    left, right = flat - x, flat + x
    nodes = left - y + unseen
    later = left + y - unseen
    nodes_x = right - y - unseen
    later_x = right + y + unseen
    nodes += np.roll(nodes_x, 1, axis=3)
    later += np.roll(later_x, 1, axis=3)
    nodes += np.roll(later, 1, axis=2)
    return nodes
