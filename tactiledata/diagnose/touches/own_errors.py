"""Errors that one trajectory has by itself: zero of the force sensor, place of the touch, factor on its forces.

These unknowns have a prior and are marginalised when trajectories are whitened, so that trajectories stay independent
of each other. The contact offset, whose influence is not linear, is fitted instead (`tactiledata.nuisance.offsets`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.history import largest_so_far
from tactiledata.diagnose.touches.played_columns import moved_wrench, wrench_at_height
from tactiledata.diagnose.touches.touch_case import TouchCase
from tactiledata.nuisance.tare import tare_variance

COMPONENTS = ("fx", "fy", "fz", "tx", "ty", "tz")
"""Components of a wrench, in their order."""
FACTORS = ("factor on forces", "factor on shear")
"""Names of the unknowns whose deviation differs by indenter: a simulation errs most where an edge presses."""


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
    sizes : dict, indenter -> float
        Factor on ``force`` and ``shear`` in touches of an indenter, as estimated from the data at hand; 1 where nothing
        is known.
    """

    slope: float = 0.01
    lever: float = 0.02
    place: float = 4e-5
    force: float = 0.01
    shear: float = 0.02
    locked: float = 0.03
    sizes: Mapping[str, float] | None = None

    def with_sizes(self, sizes: Mapping[str, float]) -> OwnErrors:
        """Return the same deviations with other factors for the indenters."""
        return replace(self, sizes=dict(sizes))

    def size(self, indenter: str) -> float:
        """Return the factor on ``force`` and ``shear`` in touches of an indenter."""
        return 1.0 if self.sizes is None else self.sizes.get(indenter, 1.0)

    def names(self) -> tuple[str, ...]:
        """Return the unknowns in words, in the order of `fields`."""
        return (
            *(f"zero of {name}" for name in COMPONENTS),
            *(f"drift of the zero of {name}" for name in COMPONENTS),
            "place along x", "place along y", *FACTORS, "held shear along x", "held shear along y",
        )  # fmt: skip

    def fields(self, case: TouchCase, wrench: Array) -> Array:
        """Return the change of a trajectory's wrenches (n, 6, r), N and N m, over one deviation of each unknown.

        Parameters
        ----------
        case : TouchCase
            The trajectory, n frames.
        wrench : (n, 6) N, N m
            Wrenches that the factors multiply: simulated ones where a fit is known, as factors on measured ones give
            readings that are too low more weight than those that are too high, and pull E down.

        Source: D'Agostini, Nucl. Instrum. Methods A 346 (1994), on uncertain normalisations.
        """
        count = len(case.touch)
        wrench = np.where(case.free_air[:, None], 0.0, np.nan_to_num(wrench))
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
        places = [self.place * moved_wrench(wrench[:, :3], np.tile(way, (count, 1))) for way in ways]
        # shear, at the tip
        shear = wrench_at_height(wrench[:, :2], tips[:, :2], tips[:, 2])
        load = wrench[:, 2]
        taken_off = largest_so_far(load, np.array([0])) - load
        taken_off = np.where(case.free_air, 0.0, taken_off)
        held = [wrench_at_height(np.outer(taken_off, way), tips[:, :2], tips[:, 2]) for way in ways]
        size = self.size(case.indenter)
        factors = [size * self.force * wrench, size * self.shear * shear]
        others = [*places, *factors, *(self.locked * pull for pull in held)]
        return np.concatenate([zero, slope, np.stack(others, axis=2)], axis=2)
