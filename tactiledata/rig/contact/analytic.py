"""One touch by the closed forms of `closed_form`, its surface by `membrane`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.rig.contact.closed_form import ContactHistory, contact_law, press_along
from tactiledata.rig.contact.contact import CONTACT_RATE, DEEPEST, RigContact, TouchSetup, contact_times, deviation_at
from tactiledata.rig.contact.inclined import touch_inclined
from tactiledata.rig.contact.membrane import surface
from tactiledata.rig.motion.motion import Path


@dataclass(frozen=True)
class AnalyticContact:
    """A `RigContact` by closed forms.

    Parameters
    ----------
    setup : TouchSetup
        The touch as it really is.
    path : Path
        The commanded path.
    history : ContactHistory
        Wrench, drag and sliding at ``CONTACT_RATE``.
    deviation : (n, 3), m, optional
        See `RigContact.deviation`.
    """

    setup: TouchSetup
    path: Path
    history: ContactHistory
    deviation: RealArray | None = None

    @property
    def wrench(self) -> RealArray:
        """Wrench (n, 6), N and N m, that the gel exerts on the indenter, gel frame about its origin."""
        return self.history.wrench

    @property
    def slipping(self) -> NDArray[np.bool_]:
        """Whether all that touches slides (n,), at ``CONTACT_RATE``."""
        return self.history.slipping

    @property
    def unsettled(self) -> int:
        """Number of steps without convergence: 0, since nothing is iterated."""
        return 0

    def surface(self, seconds: float) -> NDArray[np.float32]:
        """Return the height (n_y, n_x), m, of the gel's surface at seconds from the start."""
        footprint = self.setup.footprint
        moment = np.array([seconds])
        x, y, depth = self.path.at(moment)[0] + self.setup.offset + deviation_at(self.deviation, moment)[0]
        ticks = np.arange(len(self.history.drag))
        drag = [float(np.interp(seconds * CONTACT_RATE, ticks, column)) for column in self.history.drag.T]
        moved = (float(x - footprint.position[0]), float(y - footprint.position[1]))
        return surface(footprint, moved, float(depth), (drag[0], drag[1]), self.setup.thickness)


def touch_analytic(setup: TouchSetup, path: Path | None = None, deviation: RealArray | None = None) -> RigContact:
    """Play a touch by closed forms and return its contact; on a domed gel, in the tangent plane at the touch.

    Parameters
    ----------
    setup : TouchSetup
        The touch as it really is.
    path : Path, optional
        The path where it is planned already.
    deviation : (n, 3), m, optional
        See `RigContact.deviation`.
    """
    if setup.cap.curvature:
        return touch_inclined(setup, path, deviation, touch_analytic)
    law = contact_law(setup.indenter, setup.footprint, setup.thickness, setup.material)
    share = setup.normal_limit / setup.touch.force_limit
    path = path or setup.plan(lambda force: min(law.depth_at(force * share), DEEPEST * setup.thickness))
    positions = path.at(contact_times(path)) + setup.offset
    if deviation is not None:
        positions = positions + deviation
    return AnalyticContact(setup, path, press_along(law, positions), deviation)
