"""A touch beside the middle of a domed gel, for forms of contact that know flat gels only.

In the frame of the tangent plane at the touch the dome is a flat gel, and the indenter is rounder by the dome's
curvature.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.rig.contact.contact import PlayTouch, RigContact, TouchSetup
from tactiledata.rig.contact.footprint import CEILING, make_footprint
from tactiledata.rig.contact.gel_cap import Cap
from tactiledata.rig.motion.motion import Path

DEEPENING = np.array([1.0, 1.0, -1.0])
"""Signs that turn x, y, depth into x, y, z, and back."""


@dataclass(frozen=True)
class InclinedContact:
    """A `RigContact` on a domed gel, solved in the tangent plane at the touch.

    Its surface is seen along the plane's normal, and the dome's own shape is subtracted.

    Parameters
    ----------
    inner : RigContact
        The contact with a flat gel, in the tangent plane's frame.
    path, deviation, wrench
        See `RigContact`, in the gel's frame.
    """

    inner: RigContact
    path: Path
    deviation: RealArray | None
    wrench: RealArray

    @property
    def slipping(self) -> NDArray[np.bool_]:
        """Whether all that touches slides (n,), at ``CONTACT_RATE``."""
        return self.inner.slipping

    @property
    def unsettled(self) -> int:
        """Number of the solver's steps that did not converge."""
        return self.inner.unsettled

    def surface(self, seconds: float) -> NDArray[np.float32]:
        """Return the height (n_y, n_x), m, of the gel's surface over the tangent plane at seconds from the start."""
        return self.inner.surface(seconds)


def touch_inclined(
    setup: TouchSetup, path: Path | None, deviation: RealArray | None, play: PlayTouch
) -> InclinedContact:
    """Play a touch on a domed gel and return its contact.

    An indenter that is pressed straight down slides along the inclined surface, and the force on it is not vertical.
    The plane stays that at the touch's position, also when the indenter slides on.

    Parameters
    ----------
    setup : TouchSetup
        The touch as it really is.
    path : Path or None
        The path where it is planned already.
    deviation : (n, 3), m, or None
        See `RigContact.deviation`.
    play : callable
        Plays a touch on a flat gel.
    """
    level = replace(setup, cap=Cap())
    # a plan follows forces along z, as a gel that is not inclined gives them
    path = path or play(level, None, None).path
    gel_from_plane = _turn(setup.cap.downhill(setup.touch.position))
    moves = DEEPENING[:, None] * gel_from_plane.T * DEEPENING
    flat, flat_path = _in_plane(setup, level, path, gel_from_plane, moves)
    inner = play(flat, flat_path, None if deviation is None else deviation @ moves.T)
    return InclinedContact(inner, path, deviation, _in_gel(inner.wrench, setup, gel_from_plane))


def _turn(downhill: RealArray) -> RealArray:
    """Return the rotation gel_from_plane (3, 3): the shortest one from gel z to the surface's normal."""
    normal = np.array([*downhill, 1.0]) / np.sqrt(1.0 + downhill @ downhill)
    axis = np.cross([0.0, 0.0, 1.0], normal)
    cross = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.eye(3) + cross + cross @ cross / (1.0 + normal[2])


def _in_plane(
    setup: TouchSetup, level: TouchSetup, path: Path, gel_from_plane: RealArray, moves: RealArray
) -> tuple[TouchSetup, Path]:
    """Return the touch and its path over the tangent plane, which meets the gel's surface at the touch's position.

    ``moves`` (3, 3) turns x, y, depth over the gel into those over the plane.
    """
    # the indenter over the plane: turned, and higher by what the dome falls
    rotation = gel_from_plane.T @ setup.rotation
    grid = setup.footprint.grid
    footprint = make_footprint(setup.indenter, rotation, setup.touch.position, grid)
    beside = (grid.x - setup.touch.position[0])[None, :], (grid.y - setup.touch.position[1])[:, None]
    footprint = replace(footprint, heights=np.minimum(footprint.heights + setup.cap.fall(*beside), CEILING))
    # the path over the plane
    place = np.array([*setup.touch.position, 0.0])
    # depths are of the lowest point, which is another part of the body over the plane
    lowest = moves @ np.array([0.0, 0.0, setup.footprint.lowest]) - np.array([0.0, 0.0, footprint.lowest])
    positions = (path.positions - place) @ moves.T + lowest
    positions[:, 2] -= setup.cap.fall(positions[:, 0], positions[:, 1])
    body: Any = setup.indenter
    if body.shape == "sphere":
        # its closed form asks for the radius: curvatures add (Hertz)
        body = replace(body, radius=1 / (1 / body.radius + setup.cap.curvature))
    flat = replace(level, indenter=body, rotation=rotation, footprint=footprint, offset=moves @ setup.offset)
    return flat, replace(path, positions=positions + place)


def _in_gel(wrench: RealArray, setup: TouchSetup, gel_from_plane: RealArray) -> RealArray:
    """Return the wrench (n, 6), N and N m, gel frame about its origin, from that in the plane's frame."""
    place = np.array([*setup.touch.position, 0.0])
    low = place - np.array([0.0, 0.0, setup.cap.fall(*setup.touch.position)])
    torque = (wrench[:, 3:] - np.cross(place, wrench[:, :3])) @ gel_from_plane.T
    force = wrench[:, :3] @ gel_from_plane.T
    return np.concatenate([force, torque + np.cross(low, force)], axis=1)
