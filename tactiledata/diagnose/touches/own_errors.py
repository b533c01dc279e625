"""Errors that one trajectory has by itself: zero of the force sensor, place of the touch, factor on its forces.

These unknowns have a prior and are marginalised when trajectories are whitened, so that trajectories stay independent
of each other. The contact offset, whose influence is not linear, is fitted instead (`tactiledata.nuisance.offsets`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.history import largest_so_far
from tactiledata.diagnose.touches.played_columns import moved_wrench, wrench_at_height
from tactiledata.diagnose.touches.touch_case import TouchCase
from tactiledata.nuisance.tare import tare_variance

COMPONENTS = ("fx", "fy", "fz", "tx", "ty", "tz")
"""Components of a wrench, in their order."""


@dataclass(frozen=True)
class OwnErrors:
    """Standard deviations of what is off in one trajectory alone.

    Parameters
    ----------
    slope : float
        Change of the force sensor's zero, N, and of its torque over `lever`, while a trajectory lasts.
    lever : float
        Length, m, that turns the change of a force's zero into that of a torque's.
    place : float
        Place of the touch along x and y, m.
    force : float
        Factor on all forces, about 1.
    shear : float
        Factor on the shear, about 1.
    locked : float
        Shear that friction still holds while a touch is taken off, as a share of the normal load that has been taken
        off.
    """

    slope: float = 0.01
    lever: float = 0.02
    place: float = 4e-5
    force: float = 0.01
    shear: float = 0.02
    locked: float = 0.03

    def names(self) -> tuple[str, ...]:
        """Return the unknowns in words, in the order of `fields`."""
        return (
            *(f"zero of {name}" for name in COMPONENTS),
            *(f"drift of the zero of {name}" for name in COMPONENTS),
            "place along x", "place along y", "factor on forces", "factor on shear", "held shear along x",
            "held shear along y",
        )  # fmt: skip

    def fields(self, case: TouchCase) -> Array:
        """Return the change of a trajectory's wrenches (n, 6, r), N and N m, over one deviation of each unknown.

        They are computed from the measured forces, so that they do not depend on what is fitted.

        Parameters
        ----------
        case : TouchCase
            The trajectory, n frames.
        """
        count = len(case.touch)
        measured = np.where(case.free_air[:, None], 0.0, np.nan_to_num(case.measured))
        tips = np.nan_to_num(case.touch.tips)
        # zero: noise of a reading over the root of the number of readings; its drift grows from 0 at the first frame
        reading = case.noise.reading_variance * case.noise.memory
        variance = float(tare_variance(np.array([case.free_samples]), reading)[0])
        zero = np.broadcast_to(np.sqrt(variance) * np.linalg.inv(case.noise.whitened(np.eye(6))).T, (count, 6, 6))
        since = case.touch.seconds - case.touch.seconds[0]
        share = since / max(float(since[-1]), 1e-9)
        sizes = self.slope * np.array([1.0, 1.0, 1.0, self.lever, self.lever, self.lever])
        slope = share[:, None, None] * np.diag(sizes)
        # place: a force that attacks elsewhere has another torque
        ways = np.eye(2)
        places = [self.place * moved_wrench(measured[:, :3], np.tile(way, (count, 1))) for way in ways]
        # shear, at the tip
        shear = wrench_at_height(measured[:, :2], tips[:, :2], tips[:, 2])
        load = measured[:, 2]
        taken_off = largest_so_far(load, np.array([0])) - load
        taken_off = np.where(case.free_air, 0.0, taken_off)
        held = [wrench_at_height(np.outer(taken_off, way), tips[:, :2], tips[:, 2]) for way in ways]
        others = [
            *places, self.force * measured, self.shear * shear, *(self.locked * pull for pull in held),
        ]  # fmt: skip
        return np.concatenate([zero, slope, np.stack(others, axis=2)], axis=2)
