"""The nodes of the layer solver: a square grid in the plane, and columns of nodes through the thickness.

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
"""Width of the empty window beyond the pad, m, so that its sides are free."""
UPPER_CELLS, UPPER_SHARE = 12, 0.36
"""Height of the uppermost element in pitches, and its largest share of the thickness."""
GROWTH = 3.0
"""Ratio of the heights of neighbouring elements, lower over upper."""
DEGREE = 4
"""Degree of the polynomials through each element."""


@dataclass(frozen=True)
class Column:
    """Nodes, quadrature and derivative along the thickness.

    Parameters
    ----------
    share : (n_points,)
        Height of the quadrature points over the base, as a share of the thickness.
    weights : (n_points,) metres
        Weights of the quadrature over the thickness.
    pick, slope : (n_points, n_levels), 1 and 1/m
        Value and derivative at the quadrature points from the values at the levels, lowest first, the base left out.
    """

    share: RealArray
    weights: RealArray
    pick: RealArray
    slope: RealArray

    @classmethod
    def of(cls, thickness: float, pitch: float, degree: int = DEGREE) -> Column:
        """Return the column of a layer.

        Parameters
        ----------
        thickness : metres
            Thickness of the layer.
        pitch : metres
            Spacing of the grid in the plane, which decides the height of the upper elements.
        degree : int
            Degree of the polynomials in each element.
        """
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
    """Return the heights, m, at which elements meet, from the base to the surface."""
    height = min(UPPER_CELLS * pitch, UPPER_SHARE * thickness)
    borders = [thickness, thickness - height]
    while borders[-1] > 1.5 * GROWTH * height:
        height *= GROWTH
        borders.append(borders[-1] - height)
    return [0.0, *borders[::-1]]


def gauss_lobatto(degree: int) -> tuple[RealArray, RealArray, RealArray]:
    """Return the Gauss-Lobatto rule of a degree d on [0, 1]: points, weights and differentiation matrix.

    Points and weights are (d + 1,); the matrix (d + 1, d + 1) gives the interpolant's derivatives at the points.
    """
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
    """The grid of one pad in the plane.

    Parameters
    ----------
    pitch : metres
        Spacing of the points.
    shape : (rows, columns)
        Numbers of points of the window along y and x.
    outline : (2,), metres, optional
        Sides of the pad along x and y, in the middle of the window; without it the layer fills the window and goes on
        periodically.
    """

    pitch: float
    shape: tuple[int, int]
    outline: tuple[float, float] | None = None

    @classmethod
    def of(cls, outline: tuple[float, float], pitch: float) -> LayerGrid:
        """Return the grid of a pad with free sides (2,), m, and a spacing, m."""
        columns, rows = (next_fast_len(int(np.ceil((side + 2 * MARGIN) / pitch)), real=True) for side in outline)
        return cls(pitch, (rows, columns), outline)

    @cached_property
    def x(self) -> RealArray:
        """Coordinates x (columns,) of the points, metres, gel frame."""
        return (np.arange(self.shape[1]) - self.shape[1] // 2) * self.pitch

    @cached_property
    def y(self) -> RealArray:
        """Coordinates y (rows,) of the points, metres, gel frame."""
        return (np.arange(self.shape[0]) - self.shape[0] // 2) * self.pitch

    @cached_property
    def filling(self) -> RealArray:
        """Share of each cell that is gel (rows, columns); cell (i, j) lies between points (i, j) and (i+1, j+1)."""
        if self.outline is None:
            return np.ones(self.shape)
        shares = []
        for start, side in ((self.y, self.outline[1]), (self.x, self.outline[0])):
            overlap = np.minimum(start + self.pitch, side / 2) - np.maximum(start, -side / 2)
            shares.append(np.clip(overlap / self.pitch, 0.0, 1.0))
        return shares[0][:, None] * shares[1][None, :]
