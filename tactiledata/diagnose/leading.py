"""Drifts that remain once stronger ones are allowed for: what is said first, without its echoes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.beyond_errors import beyond_errors
from tactiledata.diagnose.instability import Drift, instability
from tactiledata.diagnose.ladder import slope
from tactiledata.diagnose.projection import Projection, project
from tactiledata.diagnose.sign_flips import DRAWS

LEVEL = 0.05
MOST = 3


def leading_drifts(
    projection: Projection,
    drifts: Sequence[Drift],
    seed: int = 0,
    draws: int = DRAWS,
    errors: Mapping[str, float] | None = None,
) -> tuple[Drift, ...]:
    """The strongest drift, then the strongest that is certain with the first one fitted, and so on; at most three.

    A scale that drifts with speed makes the offset drift with speed, too, and everything that goes with speed: those
    echoes are gone once the scale may follow the speed; what is imitated by those before ends the list. With
    ``errors`` each is beyond those (`beyond_errors`).
    """
    tested = len(projection.residuals.tested)
    found: list[Drift] = []
    fields = {}
    left = drifts
    while left and left[0].p <= LEVEL and np.isfinite(left[0].change.half_width) and len(found) < MOST:
        first = left[0]
        found.append(first)
        fields[f"{first.parameter} over {first.covariate}, {len(found)}"] = _field(projection, first)
        refitted = project(projection.residuals.with_fields(fields))
        left = beyond_errors(instability(refitted, seed + len(found), draws, tested), errors)
    return tuple(found)


def _field(projection: Projection, drift: Drift) -> NDArray[np.float64]:
    """The field (n, k) of a drift with coefficient 1: a slope over a covariate, or a level of a label."""
    residuals = projection.residuals
    place = [residuals.parameters[number].name for number in residuals.shared].index(drift.parameter)
    if drift.covariate in residuals.labels:
        instrument = (residuals.labels[drift.covariate] == drift.at).astype(np.float64)
    else:
        instrument = slope(residuals.covariates[drift.covariate].values, projection.information(place))[0][:, 0]
    return projection.directions[:, :, place] * instrument[:, None]
