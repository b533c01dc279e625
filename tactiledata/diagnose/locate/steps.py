"""Steps of a parameter from one trajectory to the next: a remount, a new zero, another sensor, a torn gel.

A step is found by circular binary segmentation (Olshen et al. 2004): of all stretches of trajectories, the one whose
mean differs most from the rest. Its p-value compares the difference with the largest one among all series after random
permutations of the trajectories. The parts on both sides are then searched in the same way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.diagnose.locate.base import Locator, LocatorInput
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import FEWEST_UNITS, ResidualParameter, Residuals
from tactiledata.diagnose.residuals.slopes import Change
from tactiledata.diagnose.residuals.wording import p_words, quantity

DRAWS = 499
"""Permutations of the trajectories: the smallest p-value is 1 / 500."""
SHORTEST = 3
"""Fewest trajectories of a stretch."""
MOST_PLACES = 80
"""Most intervals between borders that are tried; in longer series the borders are evenly spaced."""
LEVEL = 0.05
"""Largest p-value of a step that is reported, and searched further."""
POOREST = 3.0
"""Largest standard error of a trajectory's value, in medians; a less certain value is left out of the series."""


@dataclass(frozen=True)
class Series:
    """Values of one parameter for t trajectories, in the order of a covariate.

    Parameters
    ----------
    parameter : ResidualParameter
        Which parameter it is.
    values, errors : (t,)
        Departure of each trajectory from the common value, and its standard error, in the parameter's unit.
    trajectories : (t,)
        Index of each trajectory.
    """

    parameter: ResidualParameter
    values: Array
    errors: Array
    trajectories: NDArray[np.int64]


@dataclass(frozen=True)
class ChangePoint:
    """A step of a parameter between two successive trajectories.

    Parameters
    ----------
    parameter : str
        Name of the parameter.
    before, after : int
        Indices of the trajectories before and after the step.
    change : Change
        Mean of the stretch after the step minus that of the stretch before it.
    p : float
        p-value of the step, over all series.
    words : str
        The step as a clause.
    """

    parameter: str
    before: int
    after: int
    change: Change
    p: float
    words: str


def series_of(projection: ProjectedResiduals, order_by: str) -> list[Series]:
    """Return each tested parameter in each trajectory alone, ordered by the trajectories' mean of a covariate.

    A parameter that fewer than `FEWEST_UNITS` trajectories determine well has no series.
    """
    residuals = projection.residuals
    place = np.add.reduceat(residuals.covariates[order_by].values, residuals.starts) / residuals.counts
    order = np.argsort(place, kind="stable")
    # one linear step for each trajectory; what a trajectory hardly determines is left out
    listed = []
    for column, number in enumerate(residuals.tested):
        score = np.add.reduceat(
            np.einsum("nk,nk->n", projection.directions[:, :, column], projection.score), residuals.starts
        )
        information = np.add.reduceat(
            np.einsum("nk,nk->n", projection.directions[:, :, column], projection.weighed[:, :, column]),
            residuals.starts,
        )
        if not (information > 0).any():
            continue
        errors = 1.0 / np.sqrt(np.maximum(information, 1e-300))
        is_certain = (errors < POOREST * np.median(errors[information > 0]))[order]
        chosen = order[is_certain]
        if len(chosen) >= FEWEST_UNITS:
            values = score[chosen] / information[chosen]
            listed.append(Series(residuals.parameters[number], values, errors[chosen], chosen))
    return listed


def change_points(
    projection: ProjectedResiduals, order_by: str = "index", seed: int = 0, draws: int = DRAWS
) -> tuple[ChangePoint, ...]:
    """Return certain steps of the tested parameters from one trajectory to the next, the smallest p-value first.

    A step is certain at a p-value of at most 0.05, over all places where it could be. A parameter may have several.

    There are none where steps cannot be tested (`can_step`): the covariate is missing, or trajectories are exchanged in
    larger blocks. Tested parameters are those that all trajectories share and that `ResidualParameter.is_tested` marks.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals after the refit.
    order_by : str
        Covariate whose mean orders the trajectories, such as the time or ``"index"``.
    seed : int
        Random seed of the permutations.
    draws : int
        Number of permutations.

    Raises
    ------
    TactileDataError
        There are too few units of exchange.
    """
    residuals = projection.residuals
    residuals.need_units("steps along time")
    if not can_step(residuals, order_by):
        return ()
    series = series_of(projection, order_by)
    unit = residuals.covariates[order_by].unit
    place = np.add.reduceat(residuals.covariates[order_by].values, residuals.starts) / residuals.counts
    # each border with the stretches on both of its sides
    points = []
    rng = np.random.default_rng(seed)
    for values_of, borders in zip(series, segment(series, rng, draws), strict=True):
        ends = [0, *(border for border, _ in borders), len(values_of.values)]
        for position, (border, p) in enumerate(borders):
            shift = _difference(values_of, slice(ends[position], border), slice(border, ends[position + 2]))
            before, after = int(values_of.trajectories[border - 1]), int(values_of.trajectories[border])
            at = f"{order_by} {quantity(float(place[before]), unit)} and {quantity(float(place[after]), unit)}"
            words = f"{shift.words} in one step between {at}{_relabelled(projection, before, after)} ({p_words(p)})"
            points.append(ChangePoint(values_of.parameter.name, before, after, shift, p, words))
    return tuple(sorted(points, key=lambda step: step.p))


def can_step(residuals: Residuals, order_by: str) -> bool:
    """Return whether steps can be tested: the covariate exists, and no unit of exchange is larger than a trajectory."""
    return order_by in residuals.covariates and residuals.blocks is None


def segment(series: list[Series], rng: np.random.Generator, draws: int = DRAWS) -> list[list[tuple[int, float]]]:
    """Return the borders of each series, ascending, with p-values; first borders are family-wise over all series.

    Parameters
    ----------
    series : list of Series
        Values of each parameter, one for each trajectory.
    rng : numpy.random.Generator
        Source of the permutations.
    draws : int
        Number of permutations.
    """
    if not series:
        return []
    # the same permutation of the trajectories for all series keeps their correlation
    tallest = np.zeros(draws)
    longest = max(int(values_of.trajectories.max()) for values_of in series) + 1
    keys = rng.random((draws, longest))
    for values_of in series:
        shuffled = values_of.values[np.argsort(keys[:, values_of.trajectories], axis=1)]
        np.maximum(tallest, _tallest(shuffled)[0], out=tallest)
    borders = []
    for values_of in series:
        height, start, stop = (float(part[0]) for part in _tallest(values_of.values[None]))
        p = float((1 + np.count_nonzero(tallest >= height - 1e-12)) / (1 + draws))
        inner = _split(values_of.values, 0, int(start), int(stop), p, rng, draws) if p <= LEVEL else ()
        borders.append(sorted(inner))
    return borders


def _split(
    values: Array, origin: int, start: int, stop: int, p: float, rng: np.random.Generator, draws: int
) -> Iterator[tuple[int, float]]:
    """Return the borders of a stretch and, recursively, the certain borders inside the parts that they separate.

    Parameters
    ----------
    values : (t,)
        Values of one part of a series.
    origin : int
        Place of the first value in the whole series.
    start, stop : int
        Ends of the stretch that differs most, relative to ``origin``; an end of the part is no border.
    p : float
        p-value of the stretch; those inside are at least as large.
    rng : numpy.random.Generator
        Source of the permutations.
    draws : int
        Number of permutations.
    """
    edges = [edge for edge in (start, stop) if 0 < edge < len(values)]
    yield from ((origin + edge, p) for edge in edges)
    parts = [(low, values[low:high]) for low, high in zip([0, *edges], [*edges, len(values)], strict=True)]
    for low, part in parts:
        if len(part) < 2 * SHORTEST:
            continue
        shuffled = rng.permuted(np.broadcast_to(part, (draws, len(part))), axis=1)
        height, inner_start, inner_stop = (float(result[0]) for result in _tallest(part[None]))
        inner = float((1 + np.count_nonzero(_tallest(shuffled)[0] >= height - 1e-12)) / (1 + draws))
        inner *= len(parts)
        if max(inner, p) <= LEVEL:
            yield from _split(part, origin + low, int(inner_start), int(inner_stop), max(inner, p), rng, draws)


def _tallest(values: Array) -> tuple[Array, Array, Array]:
    """Return the largest studentised difference of a stretch of each row (b, t) from the rest, with start and stop."""
    count = values.shape[1]
    summed = np.concatenate([np.zeros((len(values), 1)), np.cumsum(values, axis=1)], axis=1)
    places = np.unique(np.round(np.linspace(0, count, min(count, MOST_PLACES) + 1)).astype(int))
    first, last = np.triu_indices(len(places), 1)
    start, stop = places[first], places[last]
    length = stop - start
    is_allowed = (length >= SHORTEST) & (count - length >= SHORTEST)
    # each side of the stretch must be long enough, or empty
    is_allowed &= ((start == 0) | (start >= SHORTEST)) & ((stop == count) | (count - stop >= SHORTEST))
    start, stop, length = start[is_allowed], stop[is_allowed], length[is_allowed]
    if not len(start):
        return np.zeros(len(values)), np.zeros(len(values)), np.zeros(len(values))
    # squared difference of means, weighted by the lengths, over the variance of the row
    mean = summed[:, -1:] / count
    variance = np.maximum((values**2).mean(axis=1) - mean[:, 0] ** 2, 1e-300)
    gain = (summed[:, stop] - summed[:, start] - length * mean) ** 2 / (length * (1.0 - length / count))
    best = gain.argmax(axis=1)
    return gain[np.arange(len(values)), best] / variance, start[best], stop[best]


def _difference(series: Series, before: slice, after: slice) -> Change:
    """Return the difference of the means of two stretches, after minus before; half width is two errors."""
    first, second = series.values[before], series.values[after]
    spread = np.sqrt(first.var(ddof=1) / len(first) + second.var(ddof=1) / len(second))
    return Change(series.parameter, float(second.mean() - first.mean()), float(2.0 * spread))


def _relabelled(projection: ProjectedResiduals, before: int, after: int) -> str:
    """Return a phrase on labels that change between two trajectories, the step's possible cause; empty without any."""
    residuals = projection.residuals
    rows = residuals.starts[[before, after]]
    changed = [name for name, texts in residuals.labels.items() if texts[rows[0]] != texts[rows[1]]]
    phrases = [f"{name} {residuals.labels[name][rows[0]]} to {residuals.labels[name][rows[1]]}" for name in changed]
    return f", where {' and '.join(phrases)} changes" if phrases else ""


def _find(given: LocatorInput) -> tuple[ChangePoint, ...] | None:
    """Return the steps of the shared parameters between trajectories; ``None`` where steps cannot be asked for."""
    if not can_step(given.residuals, given.order_by):
        return None
    return change_points(given.projection, given.order_by, given.seed + 4)


LOCATOR = Locator("steps", _find, lambda step: {"parameter": step.parameter, "change": step.change}, most_said=3)
