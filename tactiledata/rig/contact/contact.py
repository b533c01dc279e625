"""The interface of every form of the rig's contact: the touch that is played, and the contact that results."""

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
"""Rate, Hz, of the history of a contact."""
DEEPEST = 0.5
"""Deepest press as a share of the gel's thickness."""


@dataclass(frozen=True)
class TouchSetup:
    """One touch, ready to be played.

    Parameters
    ----------
    touch : TouchPlan
        What the arm was commanded to do.
    indenter : Indenter
        The real indenter.
    rotation : (3, 3)
        Orientation of the indenter, gel_from_indenter.
    footprint : Footprint
        The turned indenter over the gel.
    offset : (3,), metres
        Constant error of arm and mount that adds to the path: x, y, depth.
    thickness : metres
        Real thickness of the gel; on a dome that at the touch's position.
    material : Material
        The gel's material.
    plan : callable
        Gives the path, from a function that gives the depth, m, at which the normal force reaches a limit, N.
    cap : Cap
        The outer surface; ``offset`` counts depth from its height at the touch's position.
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
        """Limit of the normal force, N: in touches with shear lower than the stated one, which includes friction."""
        shears = any(step.kind in ("shear", "reverse") for step in self.touch.steps)
        return self.touch.force_limit / (float(np.hypot(1.0, self.material.friction)) if shears else 1.0)


class RigContact(Protocol):
    """The contact of one touch: the wrench, the sliding and the surface of the gel over time."""

    @property
    def path(self) -> Path:
        """Commanded path of the indenter over the gel."""

    @property
    def deviation(self) -> RealArray | None:
        """Error of the arm that adds to path and offset, (n, 3), m, at ``CONTACT_RATE``: x, y, depth."""

    @property
    def wrench(self) -> RealArray:
        """Wrench (n, 6), N and N m, of the gel on the indenter at ``CONTACT_RATE``, gel frame about its origin."""

    @property
    def slipping(self) -> NDArray[np.bool_]:
        """Whether all that touches slides (n,), at ``CONTACT_RATE``."""

    @property
    def unsettled(self) -> int:
        """Number of the solver's steps that did not converge."""

    def surface(self, seconds: float) -> NDArray[np.float32]:
        """Return the height (n_y, n_x), m, of the outer surface on the footprint's grid; zero where it is at rest."""


PlayTouch = Callable[[TouchSetup, Path | None, RealArray | None], RigContact]
"""Function that plays a touch, along a path that may be planned already, with a deviation (n, 3), m, from it."""


def deviation_at(deviation: RealArray | None, seconds: RealArray) -> RealArray:
    """Return the deviation (n, 3), m, at seconds (n,), from its history at ``CONTACT_RATE``; zero without one."""
    if deviation is None:
        return np.zeros((len(seconds), 3))
    ticks = np.arange(len(deviation)) / CONTACT_RATE
    return np.stack([np.interp(seconds, ticks, column) for column in deviation.T], axis=1)


def contact_times(path: Path) -> RealArray:
    """Return the times (n,), s from the start, of the samples of a contact's history."""
    return np.arange(0.0, path.duration + 1.0 / CONTACT_RATE, 1.0 / CONTACT_RATE)
