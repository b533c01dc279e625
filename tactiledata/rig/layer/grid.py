"""The points on which the layer solver knows displacements: a square grid in the plane, columns of nodes through it.

In the plane: bilinear cells, the window repeated periodically. Through the thickness: spectral elements, finer towards
the surface, on Gauss-Lobatto points that serve as quadrature too. The lowest node is bonded and left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.fft import next_fast_len

from tactiledata.arrays import RealArray

MARGIN = 8e-4
"""m of empty window beyond the pad, so that its sides are free."""
UPPER_CELLS, UPPER_SHARE = 12, 0.36
"""Height of the uppermost element: so many pitches, at most this share of the thickness."""
GROWTH = 3.0
"""How much higher each next element is."""
DEGREE = 4
"""Of the polynomials through each element."""


@dataclass(frozen=True)
class Column:
    """Nodes, quadrature and derivative along the thickness.

    Parameters
    ----------
    share : (n_points,)
        Height of the quadrature points over the base, as a share of the thickness.
    weights : (n_points,) metres
    pick, slope : (n_points, n_levels), 1 and 1/m
        Value and derivative at the quadrature points from the values at the levels, lowest first, the base left out.
    """

    share: RealArray
    weights: RealArray
    pick: RealArray
    slope: RealArray

    @classmethod
    def of(cls, thickness: float, pitch: float, degree: int = DEGREE) -> Column:
        """Elements of one degree over a thickness (m), the upper ones fit for a grid of a pitch (m)."""
        nodes, weights, derivative = gauss_lobatto(degree)
        borders = _borders(thickness, pitch)
        levels = degree * (len(borders) - 1)
        share, weight, pick, slope = [], [], [], []
        for index, (low, high) in enumerate(pairwise(borders)):
            share.append((low + (high - low) * nodes) / thickness)
            weight.append(weights * (high - low))
            place = np.zeros((degree + 1, levels + 1))
            place[np.arange(degree + 1), index * degree + np.arange(degree + 1)] = 1.0
            pick.append(place[:, 1:])
            slope.append((derivative / (high - low) @ place)[:, 1:])
        return cls(*(np.concatenate(parts) for parts in (share, weight, pick, slope)))


def _borders(thickness: float, pitch: float) -> list[float]:
    """Heights, m, at which elements meet, from the base to the surface."""
    height = min(UPPER_CELLS * pitch, UPPER_SHARE * thickness)
    borders = [thickness, thickness - height]
    while borders[-1] > 1.5 * GROWTH * height:
        height *= GROWTH
        borders.append(borders[-1] - height)
    return [0.0, *borders[::-1]]


def gauss_lobatto(degree: int) -> tuple[RealArray, RealArray, RealArray]:
    """Points (d + 1,), weights (d + 1,) on [0, 1], and the matrix (d + 1, d + 1) of the interpolant's derivatives."""
    legendre = np.polynomial.legendre.Legendre.basis(degree)
    x = np.concatenate([[-1.0], np.sort(legendre.deriv().roots().real), [1.0]])
    value = legendre(x)
    weights = 2.0 / (degree * (degree + 1) * value**2)
    apart = x[:, None] - x[None, :] + np.eye(degree + 1)
    derivative = value[:, None] / value[None, :] / apart
    np.fill_diagonal(derivative, 0.0)
    np.fill_diagonal(derivative, -derivative.sum(axis=1))
    return (x + 1.0) / 2.0, weights / 2.0, 2.0 * derivative


@dataclass(frozen=True)
class LayerGrid:
    """The grid of one pad.

    Parameters
    ----------
    pitch : metres
    shape : (rows, columns)
        Points of the window along y and x.
    outline : (2,), metres, optional
        Sides of the pad along x and y, in the middle of the window; without it the layer fills the window and goes on
        periodically.
    """

    pitch: float
    shape: tuple[int, int]
    outline: tuple[float, float] | None = None

    @classmethod
    def of(cls, outline: tuple[float, float], pitch: float) -> LayerGrid:
        """The grid of a pad with free sides."""
        columns, rows = (next_fast_len(int(np.ceil((side + 2 * MARGIN) / pitch)), real=True) for side in outline)
        return cls(pitch, (rows, columns), outline)

    @cached_property
    def x(self) -> RealArray:
        """(columns,) metres, gel frame."""
        return (np.arange(self.shape[1]) - self.shape[1] // 2) * self.pitch

    @cached_property
    def y(self) -> RealArray:
        """(rows,) metres, gel frame."""
        return (np.arange(self.shape[0]) - self.shape[0] // 2) * self.pitch

    @cached_property
    def filling(self) -> RealArray:
        """(rows, columns): share of each cell that is gel; cell (i, j) lies between points (i, j) and (i+1, j+1)."""
        if self.outline is None:
            return np.ones(self.shape)
        shares = []
        for start, side in ((self.y, self.outline[1]), (self.x, self.outline[0])):
            overlap = np.minimum(start + self.pitch, side / 2) - np.maximum(start, -side / 2)
            shares.append(np.clip(overlap / self.pitch, 0.0, 1.0))
        return shares[0][:, None] * shares[1][None, :]
