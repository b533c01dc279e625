"""A map of a parameter over the gel, with the band in which it stays by chance."""

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
"""Places along the longer side of the map."""
WIDTHS = 6.0
"""Kernel widths along the longer side."""


@dataclass(frozen=True)
class RegionMap:
    """A parameter's departure from its mean over the plane.

    Parameters
    ----------
    parameter : str
    unit : str, of the plane
    x, y : (a,), (b,)
    departure : (b, a)
        In the parameter's unit, NaN where too few trajectories come by.
    statistic : (b, a)
        Departure over its spread.
    band : float
        Which the statistic nowhere leaves in 95 % of draws, over all maps together.
    p : float
        Of the largest departure, for all maps together.
    change : Change
        Inside the kernel about the largest departure, against the rest.
    words : str
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
    """A map of each shared parameter over two covariates, the most certain first; none where the plane is no plane.

    Raises
    ------
    TactileDataError
        Too few units of exchange.
    """
    residuals = projection.residuals
    residuals.need_units("maps")
    if across not in residuals.covariates or up not in residuals.covariates:
        return ()
    place_x, place_y = residuals.covariates[across].values, residuals.covariates[up].values
    x, y = _axes(place_x, place_y)
    if min(len(x), len(y)) < 2:
        return ()
    kernels = _kernels(place_x, place_y, x, y)
    found = [contributions(projection, place, kernels) for place in range(len(residuals.tested))]
    if not found:
        return ()
    thrown = signs(residuals.unit_count, draws, seed)
    drawn = np.stack([np.abs(one.flipped(thrown)).max(axis=1) for one in found], axis=1)
    observed = np.array([np.abs(one.statistic).max() for one in found])
    p_values = family_wise(observed, drawn)
    band = float(np.quantile(drawn.max(axis=1), 0.95))
    maps = []
    for place in np.lexsort((-observed, p_values)):
        one = found[place]
        summit = int(np.abs(one.statistic).argmax())
        moved = change(projection, int(place), kernels[:, summit])
        unit = residuals.covariates[across].unit
        at = f"{across} {quantity(x[summit % len(x)], unit)}, {up} {quantity(y[summit // len(x)], unit)}"
        maps.append(
            RegionMap(
                moved.parameter.name,
                unit,
                x,
                y,
                np.where(one.is_testable, one.size, np.nan).reshape(len(y), len(x)),
                one.statistic.reshape(len(y), len(x)),
                band,
                float(p_values[place]),
                moved,
                f"{moved.words} about {at} ({p_words(float(p_values[place]))})",
            )
        )
    return tuple(maps)


def _axes(x: Array, y: Array) -> tuple[Array, Array]:
    low, high = np.quantile([x, y], [0.02, 0.98], axis=1)
    step = float((high - low).max()) / (ACROSS - 1)
    if not step > 0:
        return np.zeros(1), np.zeros(1)
    spans = np.maximum(np.round((high - low) / step).astype(int) + 1, 1)
    return np.linspace(low[0], high[0], spans[0]), np.linspace(low[1], high[1], spans[1])


def _kernels(place_x: Array, place_y: Array, x: Array, y: Array) -> Array:
    """Gaussian kernels (n, b a) about the places of the map."""
    width = max(float(np.ptp(x)), float(np.ptp(y))) / WIDTHS
    along_x = np.exp(-0.5 * ((place_x[:, None] - x) / width) ** 2)
    along_y = np.exp(-0.5 * ((place_y[:, None] - y) / width) ** 2)
    kernels: Array = np.einsum("nb,na->nba", along_y, along_x).reshape(len(place_x), -1)
    return kernels
