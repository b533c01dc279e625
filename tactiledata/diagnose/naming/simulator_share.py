"""What a fit attributes to errors of the simulation itself, and not to physics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.residuals.residuals import joined_names
from tactiledata.diagnose.residuals.wording import percent
from tactiledata.diagnose.touches.whitened import WhitenedTouches

TOLD = 0.05
"""Share of an indenter's forces from which the error that a fit attributes to them is reported."""


@dataclass(frozen=True)
class SimulatorError:
    """One error of the simulation, as a fit has it.

    Parameters
    ----------
    what : str
        The error in words.
    deviations : float
        Fitted size in standard deviations of its prior; positive where the simulated force is too small.
    share : float
        Fitted size as a share of the force; of the growth of force, as a share over a factor e of the force.
    indenter : str
        Indenter whose forces are off; empty where the error is common to all.
    """

    what: str
    deviations: float
    share: float
    indenter: str = ""


def simulator_share(whitened: WhitenedTouches, fit: JointFit) -> list[SimulatorError]:
    """Return the simulation's errors of a fit, in the order of `WhitenedTouches.simulation_error_fields`."""
    names = [str(name) for name in np.unique(whitened.touch_set.indenters)]
    words = [*(f"all forces of {name}" for name in names), "the growth of force with depth", "shear that sticks"]
    scales = [*([whitened.errors.shape] * len(names)), whitened.errors.law, whitened.errors.shear]
    return [
        SimulatorError(what, float(size), float(size) * scale, name)
        for what, size, scale, name in zip(words, fit.model.errors, scales, [*names, "", ""], strict=True)
    ]


def simulator_share_words(errors: list[SimulatorError]) -> list[str]:
    """Return one sentence on indenters whose simulated forces are off by at least ``TOLD``; empty where none are."""
    large = [error for error in errors if error.indenter and abs(error.share) >= TOLD]
    if not large:
        return []
    listed = joined_names([
        f"{percent(abs(error.share))} too {'small' if error.share > 0 else 'large'} under {error.indenter}"
        for error in large
    ])  # fmt: skip
    return [
        f"The fit attributes these errors to the simulation itself: its forces are {listed}. A replay does not correct"
        " them."
    ]
