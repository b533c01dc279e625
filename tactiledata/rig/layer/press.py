"""A rigid body pressed along a path into an elastic layer: wrenches and surfaces on plain arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.indenters.base import Indenter
from tactiledata.rig.layer.grid import LayerGrid
from tactiledata.rig.layer.solver import TOLERANCE, Layer, PressState
from tactiledata.rig.scenario.scenario import Material


@dataclass(frozen=True)
class Press:
    """A body pressed into a layer along a path.

    Parameters
    ----------
    wrench : (n, 6), N, N m
        Wrench on the indenter, gel frame, about the gel's origin.
    surface : (n, 3, rows, columns), m
        Displacements of the gel's surface at the points of the grid.
    slipping : (n,) bool
        Whether all that touches slides.
    settled : (n,) bool
        Whether the solver converged.
    """

    wrench: RealArray
    surface: RealArray
    slipping: NDArray[np.bool_]
    settled: NDArray[np.bool_]


def solve_press(
    indenter: Indenter,
    poses: RealArray,
    thickness: float,
    material: Material,
    grid: LayerGrid,
    is_linear: bool = False,
    tolerance: float = TOLERANCE,
) -> Press:
    """Press a body along a path into a layer and return the contact, for comparisons between solvers.

    Parameters
    ----------
    indenter : Indenter
        The body.
    poses : (n, 4, 4), metres
        Poses gel_from_indenter, about 0.1 mm apart; the gel's surface at rest is z = 0, its base at -thickness. The
        first may press already: it is reached from the first touch along gel z, in one step.
    thickness : metres
        Thickness of the layer.
    material : Material
        The gel's material.
    grid : LayerGrid
        ``LayerGrid.of(outline, pitch)`` for a pad with free sides.
    is_linear : bool
        Whether strain is taken as small.
    tolerance : float
        Relative change of the force between rounds at which a step is done.

    Examples
    --------
    >>> import numpy as np
    >>> from tactiledata.indenters import make_indenter
    >>> from tactiledata.rig.scenario.scenario import Material
    >>> ball = make_indenter({"shape": "sphere", "radius": 0.004}, None, "example")
    >>> pose = np.eye(4)
    >>> pose[2, 3] = -1e-4
    >>> press = solve_press(ball, pose[None], 0.004, Material(), LayerGrid(5e-4, (32, 32)))
    >>> bool(0.11 < press.wrench[0, 2] < 0.13)
    True
    """
    layer = Layer(grid, thickness, material, is_linear, tolerance)
    state = layer.at_rest(indenter, poses[0])
    states, guess = [], None
    for index, pose in enumerate(poses):
        after = layer.step(indenter, state, pose, guess)
        guess = extrapolated(state, after, poses[index + 1]) if index + 1 < len(poses) else None
        state = after
        states.append(after)
    return Press(
        np.array([state.wrench for state in states]),
        np.array([state.u[:, -1] for state in states]),
        np.array([state.is_slipping for state in states]),
        np.array([state.is_settled for state in states]),
    )


def extrapolated(before: PressState, now: PressState, pose: RealArray) -> RealArray | None:
    """Return displacements to begin the next step with, extrapolated from the last one; None where the path turns.

    Parameters
    ----------
    before, now : PressState
        The last two states.
    pose : (4, 4), metres
        Pose of the indenter at the end of the next step, gel_from_indenter.
    """
    last, ahead = now.pose[:3, 3] - before.pose[:3, 3], pose[:3, 3] - now.pose[:3, 3]
    lengths = float(np.linalg.norm(last)), float(np.linalg.norm(ahead))
    if not now.is_touching or min(lengths) < 1e-9 or last @ ahead < 0.9 * lengths[0] * lengths[1]:
        return None
    return now.u + min(lengths[1] / lengths[0], 1.0) * (now.u - before.u)
