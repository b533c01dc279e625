"""Trajectories that were pressed, as the measured forces say, and that never touch the gel in the replay."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.contract.wording import counted
from tactiledata.gel.contact.history import FrameStatus
from tactiledata.replay.plan import PlannedTouch, ReplayPlan
from tactiledata.store.read.reader import Store

PRESSED = 1.0
"""Measured force, N, from which on a trajectory was pressed: far above the noise and drift of a force sensor."""
FAR = 0.1
"""Distance, m, that no arm holds an indenter from a gel while it presses: lengths in another unit."""
NEAR = 1e-3
"""Distance, m, that the errors of poses and places may make up, and a calibrated depth offset mends."""
MOST_TOLD = 3


@dataclass(frozen=True)
class UntouchedTouch:
    """A trajectory that was pressed and is not touched in the replay.

    Parameters
    ----------
    uid, name : str
        The trajectory.
    largest_force : float
        Largest measured contact force at its frames, N.
    frame : int
        Number, within the trajectory, of the frame with that force.
    height : float
        Height of the indenter's tip over the top of the gel at that frame, m; below it where negative.
    aside : float
        Distance of the tip from the gel's axis at that frame, m.
    """

    uid: str
    name: str
    largest_force: float
    frame: int
    height: float
    aside: float

    @property
    def words(self) -> str:
        """What was found of it."""
        side = "above" if self.height >= 0 else "below"
        return (
            f"{self.name}: up to {self.largest_force:.1f} N at frame {self.frame}, where the tip is "
            f"{1e3 * abs(self.height):.2f} mm {side} the top of the gel and {1e3 * self.aside:.1f} mm from its axis"
        )


def untouched_touches(store: Store, name: str, plan: ReplayPlan) -> tuple[UntouchedTouch, ...]:
    """Return trajectories whose measured force says that they were pressed, and that no frame of a mesh touches.

    Parameters
    ----------
    store : Store
        With the mesh.
    name : str
        Name of the mesh.
    plan : ReplayPlan
        The trajectories of the replay.
    """
    status = store.mesh(name).status()
    force = store.frames(["contact_force"])["contact_force"].to_numpy()
    found = []
    for touch in plan.touches:
        first, stop = touch.frames[0], min(touch.frames[1], len(status))
        if touch.obstacle is not None or not np.isfinite(force[first:stop]).any():
            continue
        largest = int(np.nanargmax(force[first:stop]))
        is_missed = status[first + largest] in (FrameStatus.NO_CONTACT, FrameStatus.BESIDE_THE_PAD)
        is_solved = (status[first:stop] == FrameStatus.SOLVED).any()
        if is_missed and not is_solved and force[first + largest] >= PRESSED:
            found.append(_untouched(store, touch, largest, float(force[first + largest])))
    return tuple(found)


def _untouched(store: Store, touch: PlannedTouch, frame: int, force: float) -> UntouchedTouch:
    """Return where the indenter is while the measured force is largest."""
    x, y, z = touch.gel_touch(store, 0.0).poses[frame, :3, 3]
    return UntouchedTouch(touch.uid, touch.name, force, frame, float(z), float(np.hypot(x, y)))


def untouched_lines(touches: Sequence[UntouchedTouch], store: str) -> list[str]:
    """Return what was found, what is probably wrong and what to do, as lines of text; nothing without trajectories.

    Parameters
    ----------
    touches : sequence of UntouchedTouch
    store : str
        Location of the store.
    """
    if not touches:
        return []
    highest = max(abs(touch.height) for touch in touches)
    if highest >= FAR:
        cause = "a length in millimetres where metres belong (poses, transforms, sizes), or a wrong transform"
    elif highest <= NEAR and max(touch.aside for touch in touches) <= 10 * NEAR:
        cause = "places known to some tenths of a millimetre (`tactiledata calibrate` fits how deep each touch is)"
    else:
        cause = (
            "a transform (robot.tcp_from_gel, base_from_indenter), another indenter than the one that was mounted, or "
            "the unit or origin of its mesh"
        )
    listed = "; ".join(touch.words for touch in touches[:MOST_TOLD]) + ("; …" if touches[MOST_TOLD:] else "")
    one = touches[0]
    return [
        f"  warning: {counted(len(touches), 'trajectory')} with measured forces of {PRESSED:g} N and more "
        f"{'does' if len(touches) == 1 else 'do'} not touch the gel in this replay ({listed})",
        f"    probably wrong: {cause}",
        f"    look: tactiledata scene {store} --trajectory {one.name} --frame {one.frame}; then correct the "
        "description, `tactiledata ingest … --replace`, and replay again",
    ]
