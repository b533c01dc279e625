"""What one common value of a parameter would take from the residual: a calibration, not yet a missing effect."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.diagnose.projection import project
from tactiledata.diagnose.residuals import Residuals
from tactiledata.diagnose.scores import Contributions
from tactiledata.diagnose.sign_flips import DRAWS, family_wise, signs
from tactiledata.diagnose.slopes import Change, refitted
from tactiledata.diagnose.wording import p_words


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
    if not projection.directions.shape[2]:
        return ()
    before = projection.score + projection.weighed @ projection.refit
    scores = residuals.by_unit(np.einsum("nkp,nk->np", projection.directions, before))
    gram = residuals.by_unit(np.einsum("nkp,nkp->np", projection.directions, projection.weighed))
    found = Contributions(scores, np.maximum(gram, 0.0))
    observed = np.abs(found.statistic)
    drawn = np.abs(found.flipped(signs(residuals.unit_count, draws, seed)))
    p_values = family_wise(observed, drawn)
    listed = []
    for k, moved in enumerate(refitted(projection)):
        listed.append(
            Offset(
                moved.parameter.name,
                float(p_values[k]),
                moved,
                f"{moved.words} throughout ({p_words(float(p_values[k]))})",
            )
        )
    return tuple(sorted(listed, key=lambda one: (one.p, -one.change.sharpness)))
