"""One touch by the closed forms of ``layer_contact``, its surface by ``membrane``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.rig.contact.closed_form import ContactHistory, contact_law, press_along
from tactiledata.rig.contact.contact import CONTACT_RATE, DEEPEST, Contact, TouchSetup, contact_times, missed_at
from tactiledata.rig.contact.inclined import touch_inclined
from tactiledata.rig.contact.membrane import surface
from tactiledata.rig.motion.motion import Path


@dataclass(frozen=True)
class AnalyticContact:
    """See `Contact`."""

    setup: TouchSetup
    path: Path
    history: ContactHistory
    missed: RealArray | None = None

    @property
    def wrench(self) -> RealArray:
        """See `Contact.wrench`."""
        return self.history.wrench

    @property
    def slipping(self) -> NDArray[np.bool_]:
        """See `Contact.slipping`."""
        return self.history.slipping

    @property
    def unsettled(self) -> int:
        """None: nothing is iterated."""
        return 0

    def surface(self, seconds: float) -> NDArray[np.float32]:
        """See `Contact.surface`."""
        indenter_footprint = self.setup.indenter_footprint
        moment = np.array([seconds])
        x, y, depth = self.path.at(moment)[0] + self.setup.offset + missed_at(self.missed, moment)[0]
        ticks = np.arange(len(self.history.drag))
        drag = [float(np.interp(seconds * CONTACT_RATE, ticks, column)) for column in self.history.drag.T]
        moved = (float(x - indenter_footprint.position[0]), float(y - indenter_footprint.position[1]))
        return surface(indenter_footprint, moved, float(depth), (drag[0], drag[1]), self.setup.thickness)


def touch_analytic(setup: TouchSetup, path: Path | None = None, missed: RealArray | None = None) -> Contact:
    """A touch, played.

    Parameters
    ----------
    setup : TouchSetup
    path : Path, optional
        Planned already.
    missed : (n, 3), m, optional
        See `Contact.missed`.
    """
    if setup.cap.curvature:
        return touch_inclined(setup, path, missed, touch_analytic)
    law = contact_law(setup.indenter, setup.indenter_footprint, setup.thickness, setup.material)
    share = setup.normal_limit / setup.touch.force_limit
    path = path or setup.plan(lambda force: min(law.depth_at(force * share), DEEPEST * setup.thickness))
    positions = path.at(contact_times(path)) + setup.offset
    if missed is not None:
        positions = positions + missed
    return AnalyticContact(setup, path, press_along(law, positions), missed)
