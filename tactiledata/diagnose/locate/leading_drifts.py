"""Drifts that remain certain after all stronger ones are fitted: those that no stronger drift explains."""

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
"""Largest p-value of a certain drift."""
MOST = 3
"""Most drifts that are listed."""


def leading_drifts(
    projection: ProjectedResiduals,
    drifts: Sequence[Drift],
    seed: int = 0,
    draws: int = DRAWS,
    errors: Mapping[str, float] | None = None,
) -> tuple[Drift, ...]:
    """Return the strongest drift, then those that are certain with all stronger ones fitted; at most three.

    A scale that drifts with speed makes the offset drift with speed, too, and with all that correlates with speed.
    These secondary drifts vanish once the scale may follow the speed.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals after the refit.
    drifts : sequence of Drift
        All drifts of this projection, the strongest first.
    seed : int
        Random seed of the first round; later rounds use the numbers after it.
    draws : int
        Number of sign flips.
    errors : dict, name -> float, optional
        Standard deviation that errors of the simulation cause in each parameter, as in `LocateOptions.errors`;
        p-values allow for it (`beyond_errors`).
    """
    tested = len(projection.residuals.tested)
    listed: list[Drift] = []
    fields = {}
    remaining = drifts
    while len(listed) < MOST and (strongest := _strongest(remaining, bool(listed))) is not None:
        listed.append(strongest)
        fields[f"{strongest.parameter} over {strongest.covariate}, {len(listed)}"] = _field(projection, strongest)
        refitted = project(projection.residuals.with_fields(fields))
        remaining = beyond_errors(parameter_drifts(refitted, seed + len(listed), draws, tested), errors)
    return tuple(listed)


def _strongest(drifts: Sequence[Drift], is_followed: bool) -> Drift | None:
    """Return the first certain drift whose interval excludes 0, or ``None``.

    Without such a drift the first round (``is_followed`` is False) takes the first certain one. Later rounds end, as
    fitting a slope of about 0 would change nothing.
    """
    certain = [drift for drift in drifts if drift.p <= LEVEL and np.isfinite(drift.change.half_width)]
    steady = [drift for drift in certain if drift.change.sharpness > 1.0]
    return next(iter(steady or ([] if is_followed else certain)), None)


def _field(projection: ProjectedResiduals, drift: Drift) -> NDArray[np.float64]:
    """Return the whitened field (n, k) of a drift of size 1: a slope over a covariate, or a level's indicator."""
    residuals = projection.residuals
    place = [residuals.parameters[number].name for number in residuals.shared].index(drift.parameter)
    if drift.covariate in residuals.labels:
        instrument = (residuals.labels[drift.covariate] == drift.at).astype(np.float64)
    else:
        instrument = slope(residuals.covariates[drift.covariate].values, projection.information(place))[0][:, 0]
    return projection.directions[:, :, place] * instrument[:, None]
