"""Inner loops over the frames of a play, compiled because a diagnosis calls them about a million times.

Columns of a play are the wrench (6) over Young's modulus, in m^2 and m^3, and the area of the contact in m^2.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tactiledata.arrays import Array
from tactiledata.effects.touch.state import torque_of

NORMAL = 2
"""Index of the column with the normal force."""
AREA = 6
"""Index of the column with the contact's area, after the six of the wrench."""
LEAST_FORCE = 1e-9
"""Normal force over Young's modulus, in m^2, up to which there is no contact."""


@njit(cache=True)
def pressed(columns: Array, depth: Array, tips: Array, shift: Array) -> tuple[Array, Array, Array, Array]:
    """Return wrench (n, 6), centre (n, 2), area (n,) and normal force (n,) of a contact; 0 where there is none.

    Forces are over Young's modulus, in m^2, torques in m^3, centres in metres, areas in m^2; all in the gel frame.
    Without contact the centre is that of the shifted tip.

    Parameters
    ----------
    columns : (n, 7)
        Columns of a play, interpolated.
    depth : (n,) m
        Depth of the tip below the undeformed surface.
    tips : (n, 3) m
        Positions of the tip as recorded.
    shift : (n, 2) m
        Shift along x and y of the gel.
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
        # centre of pressure from M = r x F, r at the height of the tip
        centre[frame, 0] = (height * columns[frame, 0] - columns[frame, 4]) / normal
        centre[frame, 1] = (columns[frame, 3] + height * columns[frame, 1]) / normal
        area[frame] = max(columns[frame, AREA], 0.0)
        load[frame] = normal
    return wrench, centre, area, load


@njit(cache=True)
def wrench_at_height(shear: Array, centre: Array, heights: Array) -> Array:
    """Return wrenches (n, 6), about the gel's origin, of tangential forces; components that are unknown are 0.

    Parameters
    ----------
    shear : (n, 2)
        Force along x and y, in any unit.
    centre : (n, 2) m
        Point of attack.
    heights : (n,) m
        Height of that point.
    """
    wrench = np.zeros((len(shear), 6))
    for frame in range(len(shear)):
        fx, fy = shear[frame, 0], shear[frame, 1]
        x, y, z = centre[frame, 0], centre[frame, 1], heights[frame]
        row = (fx, fy, 0.0, -z * fy, z * fx, x * fy - y * fx)
        for column in range(6):
            if not np.isnan(row[column]):
                wrench[frame, column] = row[column]
    return wrench


def moved_wrench(force: Array, motion: Array) -> Array:
    """Return the change (n, 6) of wrenches whose centre of pressure is moved along the gel: torques alone.

    Parameters
    ----------
    force : (n, 3)
        Forces, in any unit.
    motion : (n, 2) m
        Motion of the centre along x and y.
    """
    along = np.column_stack([motion, np.zeros(len(motion))])
    return np.concatenate([np.zeros_like(force), torque_of(force, along)], axis=1)


@njit(cache=True)
def cubics_at(nodes: Array, coefficients: Array, places: Array) -> Array:
    """Return values (n, c) of piecewise cubics, each frame at an argument of its own.

    `CubicsOverFriction` calls it: the argument is the friction coefficient (no unit), and the c columns are those of a
    play, with the units of their coefficients. At an inner node the piece above it is taken.

    Parameters
    ----------
    nodes : (m,)
        Ends of the pieces, ascending, at least two. Arguments beyond them are moved to the nearest end.
    coefficients : (4, m - 1, n, c)
        Of each piece, frame and column, highest power first, over the distance from the lower node.
    places : (n,)
        Argument of each frame, a finite number in the unit of the nodes.
    """
    count, width = coefficients.shape[2], coefficients.shape[3]
    columns = np.empty((count, width))
    for frame in range(count):
        argument = min(max(places[frame], nodes[0]), nodes[-1])
        below = 0
        while below < len(nodes) - 2 and argument >= nodes[below + 1]:
            below += 1
        x = argument - nodes[below]
        for column in range(width):
            third, second = coefficients[0, below, frame, column], coefficients[1, below, frame, column]
            first, none = coefficients[2, below, frame, column], coefficients[3, below, frame, column]
            columns[frame, column] = ((third * x + second) * x + first) * x + none
    return columns
