"""Whether a shared parameter is wrong by a constant in all frames: a matter of calibration, not of a missing effect."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactiledata.diagnose.locate.base import Locator, LocatorInput
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.scores import Contributions, along
from tactiledata.diagnose.residuals.sign_flips import DRAWS, family_wise, signs
from tactiledata.diagnose.residuals.slopes import Change, refitted
from tactiledata.diagnose.residuals.wording import p_words


@dataclass(frozen=True)
class Offset:
    """The shift of a shared parameter that the data ask for, with its p-value.

    Parameters
    ----------
    parameter : str
        Name of the parameter.
    p : float
        Family-wise p-value over all parameters.
    change : Change
        Shift of the parameter when all parameters are refitted together.
    words : str
        The shift as a clause.
    """

    parameter: str
    p: float
    change: Change
    words: str


def offsets(residuals: Residuals, seed: int = 0, draws: int = DRAWS) -> tuple[Offset, ...]:
    """Return the shift of every shared parameter, the most certain first; none is certain after a calibration.

    Parameters
    ----------
    residuals : Residuals
        Residuals with sensitivities of the parameters.
    seed : int
        Random seed of the sign flips.
    draws : int
        Number of sign flips.

    Raises
    ------
    TactileDataError
        There are too few units of exchange.
    """
    residuals.need_units("a common offset")
    projection = project(residuals)
    if not residuals.tested:
        return ()
    scores = [_alone(residuals, place) for place in residuals.tested]
    flips = signs(residuals.unit_count, draws, seed)
    observed = np.array([abs(float(score.statistic[0])) for score in scores])
    drawn = np.stack([np.abs(score.flipped(flips)[:, 0]) for score in scores], axis=1)
    p_values = family_wise(observed, drawn)
    listed = [
        Offset(shift.parameter.name, float(p), shift, f"{shift.offset_words} throughout ({p_words(float(p))})")
        for shift, p in zip(refitted(projection)[: len(scores)], p_values, strict=True)
    ]
    return tuple(sorted(listed, key=lambda offset: (offset.p, -offset.change.sharpness)))


def _alone(residuals: Residuals, place: int) -> Contributions:
    """Return the score of one parameter, by its index, orthogonal to all other parameters."""
    kept = [number for number in range(len(residuals.parameters)) if number != place]
    others = replace(
        residuals,
        parameters=tuple(residuals.parameters[number] for number in kept),
        sensitivities=residuals.slopes[:, :, kept],
    )
    return along(project(others), residuals.slopes[:, :, place], np.ones((len(residuals.values), 1)))


def _find(given: LocatorInput) -> tuple[Offset, ...] | None:
    """Return the offsets of all shared parameters; ``None`` where they were fitted, or where there are none."""
    return (None if given.is_fitted else offsets(given.residuals, given.seed + 1, given.draws)) or None


LOCATOR = Locator(
    "a common offset", _find, lambda offset: {"parameter": offset.parameter, "change": offset.change}, most_said=3
)
