"""Steps in what each trajectory says, along time or index: a remount, a new zero, another sensor, a torn gel.

A step is found by circular binary segmentation (Olshen et al. 2004): of all stretches, the one whose mean differs most
from the rest. Its chance is that of the largest among all series when the trajectories come in any other order; then
the stretches on both sides are searched in the same way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import FEWEST_UNITS, ResidualParameter, Residuals
from tactiledata.diagnose.residuals.slopes import Change
from tactiledata.diagnose.residuals.wording import p_words, quantity

DRAWS = 499
SHORTEST = 3
"""Trajectories in a stretch."""
MOST_PLACES = 80
"""Borders that are tried; of longer series, evenly spaced ones."""
LEVEL = 0.05
POOREST = 3.0
"""Times the median standard error: a trajectory that knows a parameter worse says nothing of it."""


@dataclass(frozen=True)
class Series:
    """One value for each of t trajectories, in order.

    Parameters
    ----------
    parameter : ResidualParameter
    values, errors : (t,)
        Departures from the common value, and their standard errors.
    trajectories : (t,)
        Their numbers.
    """

    parameter: ResidualParameter
    values: Array
    errors: Array
    trajectories: NDArray[np.int64]


@dataclass(frozen=True)
class ChangePoint:
    """A change between two trajectories.

    Parameters
    ----------
    parameter : str
    before, after : int
        Numbers of the trajectories.
    change : Change
        Mean of the stretch after it less that of the stretch before it.
    p : float
        For all series together.
    words : str
    """

    parameter: str
    before: int
    after: int
    change: Change
    p: float
    words: str


def series_of(projection: ProjectedResiduals, order_by: str) -> list[Series]:
    """What each trajectory alone says of each shared parameter, ordered by the trajectories' mean of a covariate."""
    residuals = projection.residuals
    place = np.add.reduceat(residuals.covariates[order_by].values, residuals.starts) / residuals.counts
    order = np.argsort(place, kind="stable")
    listed = []
    for k, number in enumerate(residuals.tested):
        score = np.add.reduceat(
            np.einsum("nk,nk->n", projection.directions[:, :, k], projection.score), residuals.starts
        )
        information = np.add.reduceat(
            np.einsum("nk,nk->n", projection.directions[:, :, k], projection.weighed[:, :, k]), residuals.starts
        )
        if not (information > 0).any():
            continue
        errors = 1.0 / np.sqrt(np.maximum(information, 1e-300))
        knows = (errors < POOREST * np.median(errors[information > 0]))[order]
        chosen = order[knows]
        if len(chosen) >= FEWEST_UNITS:
            values = score[chosen] / information[chosen]
            listed.append(Series(residuals.parameters[number], values, errors[chosen], chosen))
    return listed


def change_points(
    projection: ProjectedResiduals, order_by: str = "index", seed: int = 0, draws: int = DRAWS
) -> tuple[ChangePoint, ...]:
    """Steps of the shared parameters along a covariate, the most certain first; none where they cannot be asked for.

    That is where the covariate is not there, and where blocks larger than trajectories are the units of exchange.

    Raises
    ------
    TactileDataError
        Too few units of exchange.
    """
    residuals = projection.residuals
    residuals.need_units("steps along time")
    if not can_step(residuals, order_by):
        return ()
    series = series_of(projection, order_by)
    unit = residuals.covariates[order_by].unit
    place = np.add.reduceat(residuals.covariates[order_by].values, residuals.starts) / residuals.counts
    found = []
    rng = np.random.default_rng(seed)
    for one, borders in zip(series, segment(series, rng, draws), strict=True):
        ends = [0, *(border for border, _ in borders), len(one.values)]
        for position, (border, p) in enumerate(borders):
            moved = _difference(one, slice(ends[position], border), slice(border, ends[position + 2]))
            before, after = int(one.trajectories[border - 1]), int(one.trajectories[border])
            at = f"{order_by} {quantity(float(place[before]), unit)} and {quantity(float(place[after]), unit)}"
            words = f"{moved.words} in one step between {at}{_relabelled(projection, before, after)} ({p_words(p)})"
            found.append(ChangePoint(one.parameter.name, before, after, moved, p, words))
    return tuple(sorted(found, key=lambda step: step.p))


def can_step(residuals: Residuals, order_by: str) -> bool:
    """Whether steps along a covariate can be asked for."""
    return order_by in residuals.covariates and residuals.blocks is None


def segment(series: list[Series], rng: np.random.Generator, draws: int = DRAWS) -> list[list[tuple[int, float]]]:
    """For each series its borders and their p-values; the first search of all series shares one family-wise level."""
    if not series:
        return []
    # the same order of the trajectories for all series, so that what hangs together stays together
    tallest = np.zeros(draws)
    longest = max(int(one.trajectories.max()) for one in series) + 1
    keys = rng.random((draws, longest))
    for one in series:
        shuffled = one.values[np.argsort(keys[:, one.trajectories], axis=1)]
        np.maximum(tallest, _tallest(shuffled)[0], out=tallest)
    borders = []
    for one in series:
        height, start, stop = (float(part[0]) for part in _tallest(one.values[None]))
        p = float((1 + np.count_nonzero(tallest >= height - 1e-12)) / (1 + draws))
        found = _split(one.values, 0, int(start), int(stop), p, rng, draws) if p <= LEVEL else ()
        borders.append(sorted(found))
    return borders


def _split(
    values: Array, origin: int, start: int, stop: int, p: float, rng: np.random.Generator, draws: int
) -> Iterator[tuple[int, float]]:
    """The borders of a stretch that stands out, and those inside what they part."""
    edges = [edge for edge in (start, stop) if 0 < edge < len(values)]
    yield from ((origin + edge, p) for edge in edges)
    parts = [(low, values[low:high]) for low, high in zip([0, *edges], [*edges, len(values)], strict=True)]
    for low, part in parts:
        if len(part) < 2 * SHORTEST:
            continue
        shuffled = rng.permuted(np.broadcast_to(part, (draws, len(part))), axis=1)
        height, inner_start, inner_stop = (float(found[0]) for found in _tallest(part[None]))
        inner = float((1 + np.count_nonzero(_tallest(shuffled)[0] >= height - 1e-12)) / (1 + draws))
        inner *= len(parts)
        if max(inner, p) <= LEVEL:
            yield from _split(part, origin + low, int(inner_start), int(inner_stop), max(inner, p), rng, draws)


def _tallest(values: Array) -> tuple[Array, Array, Array]:
    """For each row (b, t) the largest studentised difference of a stretch from the rest, its start and its stop."""
    count = values.shape[1]
    summed = np.concatenate([np.zeros((len(values), 1)), np.cumsum(values, axis=1)], axis=1)
    places = np.unique(np.round(np.linspace(0, count, min(count, MOST_PLACES) + 1)).astype(int))
    first, last = np.triu_indices(len(places), 1)
    start, stop = places[first], places[last]
    length = stop - start
    is_allowed = (length >= SHORTEST) & (count - length >= SHORTEST)
    # what lies on either side of the stretch must be long enough, or nothing
    is_allowed &= ((start == 0) | (start >= SHORTEST)) & ((stop == count) | (count - stop >= SHORTEST))
    start, stop, length = start[is_allowed], stop[is_allowed], length[is_allowed]
    if not len(start):
        return np.zeros(len(values)), np.zeros(len(values)), np.zeros(len(values))
    mean = summed[:, -1:] / count
    variance = np.maximum((values**2).mean(axis=1) - mean[:, 0] ** 2, 1e-300)
    gain = (summed[:, stop] - summed[:, start] - length * mean) ** 2 / (length * (1.0 - length / count))
    best = gain.argmax(axis=1)
    return gain[np.arange(len(values)), best] / variance, start[best], stop[best]


def _difference(series: Series, before: slice, after: slice) -> Change:
    first, second = series.values[before], series.values[after]
    spread = np.sqrt(first.var(ddof=1) / len(first) + second.var(ddof=1) / len(second))
    return Change(series.parameter, float(second.mean() - first.mean()), float(2.0 * spread))


def _relabelled(projection: ProjectedResiduals, before: int, after: int) -> str:
    """Labels that change where the step is: they may be its cause."""
    residuals = projection.residuals
    rows = residuals.starts[[before, after]]
    changed = [name for name, texts in residuals.labels.items() if texts[rows[0]] != texts[rows[1]]]
    said = [f"{name} {residuals.labels[name][rows[0]]} to {residuals.labels[name][rows[1]]}" for name in changed]
    return f", where {' and '.join(said)} changes" if said else ""
