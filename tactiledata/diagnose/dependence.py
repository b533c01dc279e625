"""How a parameter departs from its common value in bins of a covariate: what an explanation should flatten."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.ladder import weighed_quantiles
from tactiledata.diagnose.projection import Projection

Array = NDArray[np.float64]

BINS = 7


@dataclass(frozen=True)
class Binned:
    """Departures of one parameter.

    Parameters
    ----------
    places : (b,)
        Weighed means of the covariate.
    departures, errors : (b,)
        In the parameter's unit; standard errors over the units of exchange.
    """

    places: Array
    departures: Array
    errors: Array


def dependence(projection: Projection, parameter: str, covariate: str) -> Binned:
    """What each bin alone says of a shared parameter, by its name."""
    residuals = projection.residuals
    names = [residuals.parameters[place].name for place in residuals.shared]
    place = names.index(parameter)
    values, weights = residuals.covariates[covariate].values, projection.information(place)
    borders = np.unique(weighed_quantiles(values, weights, np.arange(1, BINS) / BINS))
    bins = (np.digitize(values, borders)[:, None] == np.arange(len(borders) + 1)).astype(np.float64)
    score = np.einsum("nk,nk->n", projection.directions[:, :, place], projection.score)
    information = residuals.by_unit(bins * weights[:, None])
    scores = residuals.by_unit(bins * score[:, None])
    total = information.sum(axis=0)
    kept = total > 0
    total = total[kept]
    departures = scores.sum(axis=0)[kept] / total
    misfit = scores[:, kept] - departures * information[:, kept]
    places = ((bins * weights[:, None]).T @ values)[kept] / total
    return Binned(places, departures, np.sqrt((misfit**2).sum(axis=0)) / total)
