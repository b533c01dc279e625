"""A trajectory that a gel engine is asked to simulate, and its answer at each frame."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.indenters.base import Indenter


class FrameStatus(IntEnum):
    """Outcome of a simulated frame: solved, without contact, or why it could not be solved."""

    SOLVED = 0
    NO_CONTACT = 1
    POSE_MISSING = 2
    TOO_DEEP = 3
    BESIDE_THE_PAD = 4
    NOT_CONVERGED = 5

    @property
    def reason(self) -> str:
        """The outcome in words, for a user."""
        return _REASONS[self]


_REASONS = {
    FrameStatus.SOLVED: "solved",
    FrameStatus.NO_CONTACT: "the indenter does not touch the gel",
    FrameStatus.POSE_MISSING: "the pose of the indenter is missing or not a number",
    FrameStatus.TOO_DEEP: "the indenter would be deeper than the gel can be pressed",
    FrameStatus.BESIDE_THE_PAD: "the indenter is lower than the gel's surface, but beside the pad",
    FrameStatus.NOT_CONVERGED: "no equilibrium was found",
}


@dataclass(frozen=True)
class GelTouch:
    """One trajectory of one indenter relative to the gel.

    Parameters
    ----------
    indenter : Indenter
        Shape that presses.
    poses : (n, 4, 4)
        gel_from_indenter at each frame, in the order of time, metres; NaN where unknown.
    """

    indenter: Indenter
    poses: Array


@dataclass(frozen=True)
class GelHistory:
    """Answer of the gel at the n frames of one trajectory.

    Rows of frames that could not be solved are NaN; their ``status`` says why.

    Parameters
    ----------
    wrench : (n, 6) N, N m
        Wrench of the gel on the indenter, gel frame, torque about the gel's origin: pressing gives fz > 0.
    displacement : (n, v, 3) m, float32
        Displacement of the nodes that were kept, gel frame.
    node_forces : (n, s, 3) N, float32
        Force of the indenter on each surface node, gel frame.
    gaps : (n, m) m, float32
        Mean distance of each patch from the indenter; 0 in contact.
    status : (n,) int8
        Values of ``FrameStatus``.
    residual : (n,)
        Largest unbalanced nodal force over the largest contact force.
    iterations : (n,) int
        Solver iterations that each frame took.
    pressed : (n, m) bool
        True for patches that the indenter presses; false where a frame was not solved.
    resumed : (n,) bool
        True for solved frames whose path was interrupted: an earlier frame, or the way to this one, found no
        equilibrium, and the gel was released and pressed anew. Friction does not know what happened before.
    """

    wrench: Array
    displacement: NDArray[np.float32]
    node_forces: NDArray[np.float32]
    gaps: NDArray[np.float32]
    status: NDArray[np.int8]
    residual: Array
    iterations: NDArray[Any]
    pressed: NDArray[np.bool_]
    resumed: NDArray[np.bool_]
