"""What locators found as rows: for documents, tables and pages alike."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.locate.drifts import Drift
from tactiledata.diagnose.locate.event_locked import EventLocked
from tactiledata.diagnose.locate.locate import LEVEL, LocatorResults
from tactiledata.diagnose.locate.region_map import RegionMap
from tactiledata.diagnose.residuals.instruments import is_logarithmic, weighed_quantiles
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.slopes import Change
from tactiledata.diagnose.residuals.wording import p_text
from tactiledata.report.diagnosis_plots import Dependence, EventPicture, MapPicture, draw_shares
from tactiledata.report.page import Picture, Section
from tactiledata.report.plots import png_bytes

MOST_CELLS = 40


def findings(located: LocatorResults, most: int = 10) -> list[dict[str, Any]]:
    """The certain findings of each locator that is certain among all, at most so many of each."""
    rows: list[dict[str, Any]] = []
    for locator, listed in _by_locator(located):
        if located.is_certain(locator):
            rows += [{"locator": locator, **one} for one in listed if one["p"] <= LEVEL][:most]
    return rows


def located_document(located: LocatorResults) -> dict[str, Any]:
    """As in schemas/diagnosis.json."""
    return {
        "is_structured": located.is_structured,
        "p": located.p,
        "findings": findings(located),
        "excess": {
            "mean_square": located.energy.excess,
            "words": located.energy.words,
            "cells": [
                {"words": cell.words, "factors": list(cell.factors), "share": cell.share, "of_values": cell.of_values}
                for cell in located.energy.cells[:MOST_CELLS]
            ],
        },
    }


def change_document(change: Change) -> dict[str, Any]:
    """A change of a parameter."""
    share = change.value / abs(change.parameter.value) if change.is_relative else None
    width = change.half_width if np.isfinite(change.half_width) else None
    return {"value": change.value, "half_width": width, "unit": change.parameter.unit, "share": share}


def _by_locator(located: LocatorResults) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    if located.gate is not None:
        yield "size of the residual", [{"p": located.gate.p, "words": located.gate.words}]
    yield "free air", [{"p": located.free_air.p, "words": located.free_air.words}]
    yield (
        "a common offset",
        [
            {"p": one.p, "words": one.words, "parameter": one.parameter, "change": change_document(one.change)}
            for one in located.overall
        ],
    )
    for locator, drifts in (("drifting parameters", located.drifts), ("trajectories' own parameters", located.own)):
        yield (
            locator,
            [
                {
                    "p": one.p,
                    "words": one.words,
                    "parameter": one.parameter,
                    "covariate": one.covariate,
                    "change": change_document(one.change),
                }
                for one in drifts
            ],
        )
    yield (
        "events",
        [
            {"p": one.p, "words": one.words, "event": one.event, "component": one.clusters[0].component}
            for one in located.events
            if one.clusters
        ],
    )
    yield (
        "departures from events on",
        [
            {"p": one.p, "words": one.words, "event": one.event, "component": one.component}
            for one in located.departures
        ],
    )
    parameters = {one.name for one in located.projection.residuals.parameters}
    yield (
        "contrasts",
        [
            {
                "p": one.p,
                "words": one.words,
                "parameter" if one.what in parameters else "component": one.what,
                "covariate": one.along,
            }
            for one in located.contrasts
        ],
    )
    yield (
        "steps",
        [
            {"p": one.p, "words": one.words, "parameter": one.parameter, "change": change_document(one.change)}
            for one in located.steps
        ],
    )
    yield "the map", [{"p": one.p, "words": one.words, "parameter": one.parameter} for one in located.maps]
    yield "the tree", [{"p": one.p, "words": one.words, "component": one.component} for one in located.leaves]


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


def dependence(projection: ProjectedResiduals, parameter: str, covariate: str) -> Binned:
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


MOST_BARS = 24


def locators_section(located: LocatorResults, most: int = 10) -> Section:
    """p-values of all locators, and at most so many findings of each."""
    rows = [(name, p_text(p), "yes" if p <= LEVEL else "no") for name, p in located.p.items()]
    said = [("", f"{one['locator']}: {one['words']}") for one in findings(located, most)]
    text = (
        "p-values of the table hold for all locators together: where nothing is missing, one page in twenty says yes "
        "anywhere. Those of single findings hold within their locator; a finding may be the echo of another, which the "
        "sentences at the top leave out."
    )
    return Section("Where they differ", [("info", text), *said], ("locator", "p", "certain"), rows)


def shares_section(located: LocatorResults) -> Section | None:
    """Where the squares of the residual sit; ``None`` where there is no excess."""
    cells = sorted(located.energy.cells, key=lambda cell: cell.of_values - cell.share)[:MOST_BARS]
    if not cells:
        return None
    drawn = draw_shares([c.words for c in cells], [min(c.share, 1.0) for c in cells], [c.of_values for c in cells])
    picture = Picture(png_bytes(drawn), "Shares of the squared residual; ticks show an even spread.")
    return Section("Where the squares sit", [("", located.energy.words)], pictures=[picture])


def dependence_panel(projection: ProjectedResiduals, after: ProjectedResiduals | None, drift: Drift) -> Dependence:
    """Bins of a drift's covariate before and, where it is known, after."""
    residuals = projection.residuals
    covariate = residuals.covariates[drift.covariate]
    scale, unit = 1.0, drift.change.parameter.unit
    if drift.change.is_relative:
        scale, unit = 100.0 / abs(drift.change.parameter.value), "%"
    one = dependence(projection, drift.parameter, drift.covariate)
    other = None if after is None else dependence(after, drift.parameter, drift.covariate)
    return Dependence(
        drift.parameter if unit in ("", "1") else f"{drift.parameter}, {unit}",
        drift.covariate if covariate.unit in ("", "1") else f"{drift.covariate}, {covariate.unit}",
        is_logarithmic(covariate.values),
        one.places,
        scale * one.departures,
        scale * one.errors,
        # its bins are its own: drawn where those before are
        None if other is None else scale * np.interp(one.places, other.places, other.departures),
        None if other is None else scale * np.interp(one.places, other.places, other.errors),
    )


def event_picture(
    one: EventLocked, components: tuple[str, ...], note: str = "", scale: str = "times the noise"
) -> EventPicture:
    """Means about an event."""
    return EventPicture(f"{one.event}{note}", one.frames, one.mean, one.deviation, components, scale)


def map_picture(one: RegionMap, note: str = "") -> MapPicture:
    """A map; departures in per cent where the parameter's value is known."""
    parameter, scale, unit = one.change.parameter, 1.0, one.change.parameter.unit
    if one.change.is_relative:
        scale, unit = 100.0 / abs(parameter.value), "%"
    return MapPicture(
        f"{one.parameter}{note}", f"x, {one.unit}", f"y, {one.unit}", unit, one.x, one.y, scale * one.departure,
        np.abs(one.statistic) > one.band,
    )  # fmt: skip
