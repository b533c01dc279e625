"""What a fit puts down to the simulation itself: factors that it takes to be errors, and no physics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.residuals.residuals import joined_names
from tactiledata.diagnose.residuals.wording import percent
from tactiledata.diagnose.touches.whitened import WhitenedTouches

TOLD = 0.05
"""Share of an indenter's forces from which on a fit says what it takes off them."""


@dataclass(frozen=True)
class SimulatorError:
    """One error of the simulation.

    Parameters
    ----------
    what : str
    deviations : float
        That it is fitted to, in standard deviations of its prior; positive where the simulation gives too little.
    share : float
        The same as a share of the force; of the growth of force, over a factor e.
    indenter : str
        Whose forces; empty where it is of all.
    """

    what: str
    deviations: float
    share: float
    indenter: str = ""


def simulator_share(white: WhitenedTouches, fit: JointFit) -> list[SimulatorError]:
    """The errors of a fit, in the order of `WhitenedTouches.simulation_error_fields`."""
    names = [str(name) for name in np.unique(white.touch_set.indenters)]
    words = [*(f"all forces of {name}" for name in names), "the growth of force with depth", "shear that sticks"]
    scales = [*([white.errors.shape] * len(names)), white.errors.law, white.errors.shear]
    return [
        SimulatorError(what, float(size), float(size) * scale, name)
        for what, size, scale, name in zip(words, fit.model.errors, scales, [*names, "", ""], strict=True)
    ]


def simulator_share_words(blamed: list[SimulatorError]) -> list[str]:
    """What a replay does not have, in a sentence; nothing where that is little."""
    off = [one for one in blamed if one.indenter and abs(one.share) >= TOLD]
    if not off:
        return []
    listed = joined_names(
        [f"{percent(abs(one.share))} too {'small' if one.share > 0 else 'large'} under {one.indenter}" for one in off]
    )
    return [f"As errors of the simulation itself the fit takes its forces to be {listed}; a replay keeps them so."]
