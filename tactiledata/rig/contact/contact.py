"""What either form of the rig's contact takes and gives: one touch to play, and what the gel does meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.indenters.base import Indenter
from tactiledata.rig.contact.footprint import Footprint
from tactiledata.rig.contact.gel_cap import Cap
from tactiledata.rig.motion.motion import Path
from tactiledata.rig.motion.touch import TouchPlan
from tactiledata.rig.scenario.scenario import Material

CONTACT_RATE = 500.0
"""Hz at which the history of a contact is told."""
DEEPEST = 0.5
"""Share of the gel's thickness beyond which nobody presses."""


@dataclass(frozen=True)
class TouchSetup:
    """One touch, ready to be played.

    Parameters
    ----------
    touch : TouchPlan
    indenter : Indenter
    rotation : (3, 3)
        gel_from_indenter.
    footprint : Footprint
    offset : (3,), metres
        What the arm and the mount really add to the path: x, y, depth.
    thickness : metres, of the gel
    material : Material
    plan : callable
        The path, from the depth (m) at which the normal force reaches a limit (N).
    cap : Cap
        The outer surface; ``thickness`` and ``offset`` are of the gel as high as it is at the touch's position.
    """

    touch: TouchPlan
    indenter: Indenter
    rotation: RealArray
    footprint: Footprint
    offset: RealArray
    thickness: float
    material: Material
    plan: Callable[[Callable[[float], float]], Path]
    cap: Cap = field(default_factory=Cap)

    @property
    def normal_limit(self) -> float:
        """N: limit of the normal force, since the stated limit speaks of the whole force, friction included."""
        shears = any(step.kind in ("shear", "reverse") for step in self.touch.steps)
        return self.touch.force_limit / (float(np.hypot(1.0, self.material.friction)) if shears else 1.0)


class RigContact(Protocol):
    """What the gel does over one touch."""

    @property
    def path(self) -> Path:
        """As commanded."""

    @property
    def deviation(self) -> RealArray | None:
        """What the arm really adds to the path besides the offset, (n, 3) m at ``CONTACT_RATE``: x, y, depth."""

    @property
    def wrench(self) -> RealArray:
        """What the gel exerts on the indenter (n, 6) at ``CONTACT_RATE``, gel frame, about its origin: N, N m."""

    @property
    def slipping(self) -> NDArray[np.bool_]:
        """Whether all that touches slides (n,) at ``CONTACT_RATE``."""

    @property
    def unsettled(self) -> int:
        """How many steps of the solver did not come to rest."""

    def surface(self, seconds: float) -> NDArray[np.float32]:
        """Height (n_y, n_x), m, of the gel's outer surface on the footprint's grid; zero where it is at rest."""


PlayTouch = Callable[[TouchSetup, Path | None, RealArray | None], RigContact]
"""A touch, played along a path that may be planned already, and missed by (n, 3) m."""


def deviation_at(deviation: RealArray | None, seconds: RealArray) -> RealArray:
    """What the arm adds (n, 3), m, at seconds (n,), from its history at ``CONTACT_RATE``; zero without one."""
    if deviation is None:
        return np.zeros((len(seconds), 3))
    ticks = np.arange(len(deviation)) / CONTACT_RATE
    return np.stack([np.interp(seconds, ticks, column) for column in deviation.T], axis=1)


def contact_times(path: Path) -> RealArray:
    """Seconds (n,) of the history's samples."""
    return np.arange(0.0, path.duration + 1.0 / CONTACT_RATE, 1.0 / CONTACT_RATE)
