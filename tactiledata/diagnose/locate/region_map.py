"""A map of a parameter over the gel, with the band that its statistic rarely leaves by chance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.scores import contributions
from tactiledata.diagnose.residuals.sign_flips import DRAWS, family_wise, signs
from tactiledata.diagnose.residuals.slopes import Change, change
from tactiledata.diagnose.residuals.wording import p_words, quantity

ACROSS = 14
"""Number of places along the longer side of the map."""
WIDTHS = 6.0
"""Length of the longer side of the map, in widths of the kernel."""


@dataclass(frozen=True)
class RegionMap:
    """The departure of a parameter from its common value, over a plane of two covariates.

    Parameters
    ----------
    parameter : str
        Name of the parameter.
    unit : str
        Unit of ``x`` and ``y``.
    x, y : (a,), (b,)
        Coordinates of the map's columns and rows.
    departure : (b, a)
        Departure in the parameter's unit; NaN where too few trajectories come near.
    statistic : (b, a)
        Departure over its standard error, as a standard normal value.
    band : float
        95 % quantile of the largest absolute statistic of all maps, by sign flips.
    p : float
        Family-wise p-value of the largest departure, over all maps.
    change : Change
        Change of the parameter under the kernel about the largest departure.
    words : str
        The largest departure as a clause.
    """

    parameter: str
    unit: str
    x: Array
    y: Array
    departure: Array
    statistic: Array
    band: float
    p: float
    change: Change
    words: str


def region_maps(
    projection: ProjectedResiduals, across: str = "x", up: str = "y", seed: int = 0, draws: int = DRAWS
) -> tuple[RegionMap, ...]:
    """Return a map of each tested parameter over two covariates, the one with the smallest p-value first.

    A map shows by how much the parameter departs from its common value around each place on the gel. The tested
    parameters are those that all trajectories share and that `ResidualParameter.is_tested` marks, such as E and mu.
    Without one of the covariates, or where they span less than two places, there are no maps.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals after the refit of the shared parameters.
    across, up : str
        Covariates along the map's horizontal and vertical axis, in the same unit.
    seed : int
        Random seed of the sign flips.
    draws : int
        Number of sign flips.

    Raises
    ------
    TactileDataError
        There are too few units of exchange.
    """
    residuals = projection.residuals
    residuals.need_units("maps")
    if across not in residuals.covariates or up not in residuals.covariates:
        return ()
    place_x, place_y = residuals.covariates[across].values, residuals.covariates[up].values
    x, y = _axes(place_x, place_y)
    if min(len(x), len(y)) < 2:
        return ()
    # one score for each parameter and place; flips are shared, so that the maximum controls the error of all maps
    kernels = _kernels(place_x, place_y, x, y)
    scores = [contributions(projection, place, kernels) for place in range(len(residuals.tested))]
    if not scores:
        return ()
    flips = signs(residuals.unit_count, draws, seed)
    drawn = np.stack([np.abs(score.flipped(flips)).max(axis=1) for score in scores], axis=1)
    observed = np.array([np.abs(score.statistic).max() for score in scores])
    p_values = family_wise(observed, drawn)
    band = float(np.quantile(drawn.max(axis=1), 0.95))
    # the size of the largest departure of each map
    maps = []
    for place in np.lexsort((-observed, p_values)):
        score = scores[place]
        summit = int(np.abs(score.statistic).argmax())
        departure = change(projection, int(place), kernels[:, summit])
        unit = residuals.covariates[across].unit
        at = f"{across} {quantity(x[summit % len(x)], unit)}, {up} {quantity(y[summit // len(x)], unit)}"
        maps.append(
            RegionMap(
                departure.parameter.name,
                unit,
                x,
                y,
                np.where(score.is_testable, score.size, np.nan).reshape(len(y), len(x)),
                score.statistic.reshape(len(y), len(x)),
                band,
                float(p_values[place]),
                departure,
                f"{departure.words} about {at} ({p_words(float(p_values[place]))})",
            )
        )
    return tuple(maps)


def _axes(x: Array, y: Array) -> tuple[Array, Array]:
    """Return coordinates (a,) and (b,) of an even grid over the 2 % to 98 % quantiles of two covariates (n,)."""
    low, high = np.quantile([x, y], [0.02, 0.98], axis=1)
    step = float((high - low).max()) / (ACROSS - 1)
    if not step > 0:
        return np.zeros(1), np.zeros(1)
    spans = np.maximum(np.round((high - low) / step).astype(int) + 1, 1)
    return np.linspace(low[0], high[0], spans[0]), np.linspace(low[1], high[1], spans[1])


def _kernels(place_x: Array, place_y: Array, x: Array, y: Array) -> Array:
    """Return the Gaussian kernels (n, b a) about the places of the map.

    Parameters
    ----------
    place_x, place_y : (n,)
        Position of each frame.
    x, y : (a,), (b,)
        Coordinates of the map's columns and rows.
    """
    width = max(float(np.ptp(x)), float(np.ptp(y))) / WIDTHS
    along_x = np.exp(-0.5 * ((place_x[:, None] - x) / width) ** 2)
    along_y = np.exp(-0.5 * ((place_y[:, None] - y) / width) ** 2)
    kernels: Array = np.einsum("nb,na->nba", along_y, along_x).reshape(len(place_x), -1)
    return kernels
