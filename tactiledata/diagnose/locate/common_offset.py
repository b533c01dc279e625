"""What one common value of a parameter would take from the residual: a calibration, not yet a missing effect."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.scores import Contributions, along
from tactiledata.diagnose.residuals.sign_flips import DRAWS, family_wise, signs
from tactiledata.diagnose.residuals.slopes import Change, refitted
from tactiledata.diagnose.residuals.wording import p_words


@dataclass(frozen=True)
class Offset:
    """A shared parameter that stands elsewhere than the data would have it.

    Parameters
    ----------
    parameter : str
    p : float
        For all parameters together.
    change : Change
        By which it would move, all others with it.
    words : str
    """

    parameter: str
    p: float
    change: Change
    words: str


def offsets(residuals: Residuals, seed: int = 0, draws: int = DRAWS) -> tuple[Offset, ...]:
    """Every shared parameter, the most certain first; after a calibration that converged none is certain.

    Raises
    ------
    TactileDataError
        Too few units of exchange.
    """
    residuals.need_units("a common offset")
    projection = project(residuals)
    if not residuals.tested:
        return ()
    found = [_alone(residuals, place) for place in residuals.tested]
    thrown = signs(residuals.unit_count, draws, seed)
    observed = np.array([abs(float(one.statistic[0])) for one in found])
    drawn = np.stack([np.abs(one.flipped(thrown)[:, 0]) for one in found], axis=1)
    p_values = family_wise(observed, drawn)
    listed = [
        Offset(moved.parameter.name, float(p), moved, f"{moved.standing} throughout ({p_words(float(p))})")
        for moved, p in zip(refitted(projection)[: len(found)], p_values, strict=True)
    ]
    return tuple(sorted(listed, key=lambda one: (one.p, -one.change.sharpness)))


def _alone(residuals: Residuals, place: int) -> Contributions:
    """Score of one shared parameter beside all others."""
    kept = [number for number in range(len(residuals.parameters)) if number != place]
    others = replace(
        residuals,
        parameters=tuple(residuals.parameters[number] for number in kept),
        sensitivities=residuals.slopes[:, :, kept],
    )
    return along(project(others), residuals.slopes[:, :, place], np.ones((len(residuals.values), 1)))
