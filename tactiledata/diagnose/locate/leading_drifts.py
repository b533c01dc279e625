"""Drifts that remain once stronger ones are allowed for: what is said first, without its echoes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.locate.drifts import Drift, parameter_drifts
from tactiledata.diagnose.locate.simulator_errors import beyond_errors
from tactiledata.diagnose.residuals.instruments import slope
from tactiledata.diagnose.residuals.projection import ProjectedResiduals, project
from tactiledata.diagnose.residuals.sign_flips import DRAWS

LEVEL = 0.05
MOST = 3


def leading_drifts(
    projection: ProjectedResiduals,
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
    while len(found) < MOST and (first := _strongest(left, bool(found))) is not None:
        found.append(first)
        fields[f"{first.parameter} over {first.covariate}, {len(found)}"] = _field(projection, first)
        refitted = project(projection.residuals.with_fields(fields))
        left = beyond_errors(parameter_drifts(refitted, seed + len(found), draws, tested), errors)
    return tuple(found)


def _strongest(drifts: Sequence[Drift], is_followed: bool) -> Drift | None:
    """Of those that are certain, the first whose slope is told from none; without such a one, and none said yet, the
    first: fitting a slope that is none would leave it as it is.
    """
    certain = [one for one in drifts if one.p <= LEVEL and np.isfinite(one.change.half_width)]
    steady = [one for one in certain if one.change.sharpness > 1.0]
    return next(iter(steady or ([] if is_followed else certain)), None)


def _field(projection: ProjectedResiduals, drift: Drift) -> NDArray[np.float64]:
    """The field (n, k) of a drift with coefficient 1: a slope over a covariate, or a level of a label."""
    residuals = projection.residuals
    place = [residuals.parameters[number].name for number in residuals.shared].index(drift.parameter)
    if drift.covariate in residuals.labels:
        instrument = (residuals.labels[drift.covariate] == drift.at).astype(np.float64)
    else:
        instrument = slope(residuals.covariates[drift.covariate].values, projection.information(place))[0][:, 0]
    return projection.directions[:, :, place] * instrument[:, None]
