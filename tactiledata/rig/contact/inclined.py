"""A touch beside the middle of a domed gel, for forms of contact that know flat gels only: seen in the frame of the
tangent plane at the touch, in which the dome is a flat gel under an indenter that is rounder by so much.
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
"""Turns x, y, depth into x, y, z, and back."""


@dataclass(frozen=True)
class InclinedContact:
    """See `RigContact`; ``inner`` is told in the tangent plane's frame, the rest in the gel's.

    Its surface is seen along the plane's normal, from which the dome is taken away.
    """

    inner: RigContact
    path: Path
    deviation: RealArray | None
    wrench: RealArray

    @property
    def slipping(self) -> NDArray[np.bool_]:
        """See `RigContact.slipping`."""
        return self.inner.slipping

    @property
    def unsettled(self) -> int:
        """See `RigContact.unsettled`."""
        return self.inner.unsettled

    def surface(self, seconds: float) -> NDArray[np.float32]:
        """See `RigContact.surface`."""
        return self.inner.surface(seconds)


def touch_inclined(
    setup: TouchSetup, path: Path | None, deviation: RealArray | None, play: PlayTouch
) -> InclinedContact:
    """A touch of a domed gel.

    Pressed straight down, the indenter slides along the surface, and what presses on it is not vertical. The plane is
    that at the touch's position, also when the indenter slides on. ``play`` knows flat gels.
    """
    level = replace(setup, cap=Cap())
    # a plan follows forces along z, as a gel that is not inclined gives them
    path = path or play(level, None, None).path
    gel_from_plane = _turn(setup.cap.downhill(setup.touch.position))
    moves = DEEPENING[:, None] * gel_from_plane.T * DEEPENING
    flat, led = _in_plane(setup, level, path, gel_from_plane, moves)
    found = play(flat, led, None if deviation is None else deviation @ moves.T)
    return InclinedContact(found, path, deviation, _in_gel(found.wrench, setup, gel_from_plane))


def _turn(downhill: RealArray) -> RealArray:
    """Rotation (3, 3), gel_from_plane, by the shortest way from gel z to the surface's normal."""
    normal = np.array([*downhill, 1.0]) / np.sqrt(1.0 + downhill @ downhill)
    axis = np.cross([0.0, 0.0, 1.0], normal)
    cross = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.eye(3) + cross + cross @ cross / (1.0 + normal[2])


def _in_plane(
    setup: TouchSetup, level: TouchSetup, path: Path, gel_from_plane: RealArray, moves: RealArray
) -> tuple[TouchSetup, Path]:
    """The touch and its path over the tangent plane, which meets the gel's surface at the touch's position.

    Moves (3, 3) turn x, y, depth over the gel into those over the plane.
    """
    rotation = gel_from_plane.T @ setup.rotation
    grid = setup.footprint.grid
    footprint = make_footprint(setup.indenter, rotation, setup.touch.position, grid)
    beside = (grid.x - setup.touch.position[0])[None, :], (grid.y - setup.touch.position[1])[:, None]
    footprint = replace(footprint, heights=np.minimum(footprint.heights + setup.cap.fall(*beside), CEILING))
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
    """Wrench (n, 6), gel frame about its origin, from that in the plane's."""
    place = np.array([*setup.touch.position, 0.0])
    low = place - np.array([0.0, 0.0, setup.cap.fall(*setup.touch.position)])
    torque = (wrench[:, 3:] - np.cross(place, wrench[:, :3])) @ gel_from_plane.T
    force = wrench[:, :3] @ gel_from_plane.T
    return np.concatenate([force, torque + np.cross(low, force)], axis=1)
