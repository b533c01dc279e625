"""The linear layer, inverted exactly, wave by wave: the preconditioner of the large strains and the contact's kernel.

Isotropic and linear, bonded below, on the same grid and with the same quadrature as `strain`: one point per
cell in the plane, and the shear energy of the mode that this point does not see. For each wave vector the components
along it and upwards are coupled, the one across stands alone; with the upward one a quarter period out of phase all
matrices are real.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from tactiledata.arrays import RealArray
from tactiledata.rig.layer.grid import Column, LayerGrid

Spectrum = NDArray[np.complexfloating[Any, Any]]


class LayerKernel:
    """The inverse of the linear layer's stiffness: displacements from forces.

    Parameters
    ----------
    grid : LayerGrid
        The window; taken as filled, without sides.
    column : Column
        Nodes through the thickness.
    shear, lame : Pa
        Lamé's constants mu and lambda.
    """

    def __init__(self, grid: LayerGrid, column: Column, shear: float, lame: float) -> None:
        # wave vectors of the grid's differences, and their directions
        self.shape = grid.shape
        pitch = grid.pitch
        half_y = np.pi * np.fft.fftfreq(grid.shape[0])[:, None]
        half_x = np.pi * np.fft.rfftfreq(grid.shape[1])[None, :]
        along_x = (2 / pitch * np.sin(half_x) * np.cos(half_y)).ravel()
        along_y = (2 / pitch * np.cos(half_x) * np.sin(half_y)).ravel()
        wave = np.hypot(along_x, along_y)
        still = wave < 1e-9 / pitch
        self._e_x = np.where(still, 1.0, along_x / np.where(still, 1.0, wave))
        self._e_y = np.where(still, 0.0, along_y / np.where(still, 1.0, wave))
        # one matrix per wave, inverted once
        mean = (np.cos(half_x) * np.cos(half_y)).ravel()
        twist = 16 * (np.sin(half_x) * np.sin(half_y)).ravel() ** 2
        coupled, across = _stiffness(column, wave, mean, twist * shear, pitch, shear, lame)
        area = pitch**2
        self._coupled = np.linalg.inv(coupled) / area
        self._across = np.linalg.inv(across) / area
        self._surface = self._surface_symbol()

    def _surface_symbol(self) -> Spectrum:
        """Return the surface displacement per surface force, (3, 3, waves), m/N, in the axes x, y, z."""
        levels = self._across.shape[1]
        top, up = levels - 1, 2 * levels - 1
        along, across, normal = self._coupled[:, top, top], self._across[:, top, top], self._coupled[:, up, up]
        mixed = self._coupled[:, top, up]
        x, y = self._e_x, self._e_y
        symbol = np.empty((3, 3, len(x)), dtype=complex)
        symbol[0, 0] = along * x * x + across * y * y
        symbol[1, 1] = along * y * y + across * x * x
        symbol[0, 1] = symbol[1, 0] = (along - across) * x * y
        # u_z = i v: a force f_z on u_z is -i f_z on v
        symbol[0, 2], symbol[1, 2] = -1j * mixed * x, -1j * mixed * y
        symbol[2, 0], symbol[2, 1] = 1j * mixed * x, 1j * mixed * y
        symbol[2, 2] = normal
        return symbol

    def displace(self, force: RealArray) -> RealArray:
        """Return the displacements (3, levels, rows, columns), m, of the layer under nodal forces of that shape, N."""
        # forces along the wave, upwards and across it
        levels = force.shape[1]
        spectrum = fft.rfft2(force).reshape(3, levels, -1)
        x, y = self._e_x, self._e_y
        both = np.empty((len(x), 2 * levels, 2))
        side = np.empty((len(x), levels, 2))
        along = spectrum[0] * x + spectrum[1] * y
        both[:, :levels, 0], both[:, :levels, 1] = along.real.T, along.imag.T
        both[:, levels:, 0], both[:, levels:, 1] = spectrum[2].imag.T, -spectrum[2].real.T
        across = spectrum[1] * x - spectrum[0] * y
        side[:, :, 0], side[:, :, 1] = across.real.T, across.imag.T
        # displacements, and back to the axes x, y, z
        both, side = self._coupled @ both, self._across @ side
        along = (both[:, :levels, 0] + 1j * both[:, :levels, 1]).T
        across = (side[:, :, 0] + 1j * side[:, :, 1]).T
        spectrum[0] = along * x - across * y
        spectrum[1] = along * y + across * x
        spectrum[2] = (-both[:, levels:, 1] + 1j * both[:, levels:, 0]).T
        return fft.irfft2(spectrum.reshape(3, levels, self.shape[0], -1), s=self.shape)

    def displace_surface(self, force: RealArray) -> RealArray:
        """Return the surface displacements (3, rows, columns), m, under surface forces of that shape, N."""
        spectrum = fft.rfft2(force).reshape(3, -1)
        moved = (self._surface * spectrum[None]).sum(axis=1)
        return fft.irfft2(moved.reshape(3, self.shape[0], -1), s=self.shape)


def _stiffness(
    column: Column, wave: RealArray, mean: RealArray, twist: RealArray, pitch: float, shear: float, lame: float
) -> tuple[RealArray, RealArray]:
    """Return the stiffness per area of each wave: of the coupled components (waves, 2 levels, 2 levels), and across."""
    weight = column.weights[:, None]
    mass = column.pick.T @ (weight * column.pick)
    bend = column.slope.T @ (weight * column.slope)
    cross = column.pick.T @ (weight * column.slope)
    k, c = wave[:, None, None], mean[:, None, None]
    unseen = twist[:, None, None] * unseen_shape(column, pitch)
    levels = len(mass)
    coupled = np.empty((len(wave), 2 * levels, 2 * levels))
    coupled[:, :levels, :levels] = (lame + 2 * shear) * k**2 * mass + shear * c**2 * bend + unseen
    coupled[:, levels:, levels:] = (lame + 2 * shear) * c**2 * bend + shear * k**2 * mass + unseen
    coupled[:, :levels, levels:] = k * c * (lame * cross - shear * cross.T)
    coupled[:, levels:, :levels] = np.swapaxes(coupled[:, :levels, levels:], 1, 2)
    return coupled, shear * (k**2 * mass + c**2 * bend) + unseen


def unseen_shape(column: Column, pitch: float) -> RealArray:
    """Return the matrix (levels, levels) of the shear energy in the mode that one point per cell does not see.

    The mode alternates between the corners of a cell, and its amplitude is the sum of the corners with alternating
    signs. The energy is per cell area and shear modulus. Bilinear shape functions, integrated exactly, give 1/6 of the
    square in the plane and a²/144 for its slope upwards.
    """
    weight = column.weights[:, None]
    mass = column.pick.T @ (weight * column.pick) / (6 * pitch**2)
    bend = column.slope.T @ (weight * column.slope) / 144
    return mass + bend
