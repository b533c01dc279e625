"""What stands in the columns of a play, read out frame by frame: compiled, as a diagnosis asks a million times."""

from __future__ import annotations

import numpy as np
from numba import njit

from tactiledata.arrays import Array

AREA = 6
"""Column of the contact's area; the wrench stands before it."""
LEAST_FORCE = 1e-9
"""m^2, over Young's modulus: less is no contact."""


@njit(cache=True)
def pressed(columns: Array, depth: Array, tips: Array, shift: Array) -> tuple[Array, Array, Array, Array]:
    """Wrench (n, 6), centre (n, 2), m, area (n,), m^2, and normal force (n,) of a contact; 0 where there is none.

    Without contact the centre is below the tip. Forces are over Young's modulus.

    Parameters
    ----------
    columns : (n, 7)
    depth : (n,) m
        Of the tip below the undeformed surface.
    tips : (n, 3) m
        As recorded.
    shift : (n, 2) m
        Of the whole path, along the gel.
    """
    count = len(depth)
    wrench, centre = np.zeros((count, 6)), np.empty((count, 2))
    area, load = np.zeros(count), np.zeros(count)
    for frame in range(count):
        normal, height = columns[frame, 2], tips[frame, 2]
        if not (normal > LEAST_FORCE and depth[frame] > 0):
            centre[frame, 0] = tips[frame, 0] + shift[frame, 0]
            centre[frame, 1] = tips[frame, 1] + shift[frame, 1]
            continue
        for column in range(6):
            wrench[frame, column] = columns[frame, column]
        # of the pressure on the surface: M = r x F with r at the height of the tip
        centre[frame, 0] = (height * columns[frame, 0] - columns[frame, 4]) / normal
        centre[frame, 1] = (columns[frame, 3] + height * columns[frame, 1]) / normal
        area[frame] = max(columns[frame, AREA], 0.0)
        load[frame] = normal
    return wrench, centre, area, load


@njit(cache=True)
def wrench_at_height(shear: Array, centre: Array, heights: Array) -> Array:
    """Wrenches (n, 6) of forces (n, 2) along the gel at points (n, 2), m, and heights (n,), m; 0 where unknown."""
    wrench = np.zeros((len(shear), 6))
    for frame in range(len(shear)):
        fx, fy = shear[frame, 0], shear[frame, 1]
        x, y, z = centre[frame, 0], centre[frame, 1], heights[frame]
        told = (fx, fy, 0.0, -z * fy, z * fx, x * fy - y * fx)
        for column in range(6):
            if not np.isnan(told[column]):
                wrench[frame, column] = told[column]
    return wrench


@njit(cache=True)
def cubics_at(nodes: Array, coefficients: Array, places: Array) -> Array:
    """Piecewise cubics (4, m - 1, n, c) between nodes (m,), each frame at its own place (n,); see `CubicsOverFriction`.

    The coefficient of the third power comes first.
    """
    count, width = coefficients.shape[2], coefficients.shape[3]
    columns = np.empty((count, width))
    for frame in range(count):
        wanted = min(max(places[frame], nodes[0]), nodes[-1])
        below = 0
        while below < len(nodes) - 2 and wanted >= nodes[below + 1]:
            below += 1
        x = wanted - nodes[below]
        for column in range(width):
            third, second = coefficients[0, below, frame, column], coefficients[1, below, frame, column]
            first, none = coefficients[2, below, frame, column], coefficients[3, below, frame, column]
            columns[frame, column] = ((third * x + second) * x + first) * x + none
    return columns
