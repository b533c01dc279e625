"""Results of the locators as rows of documents, tables and pictures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.locate import LOCATORS
from tactiledata.diagnose.locate.drifts import Drift
from tactiledata.diagnose.locate.event_locked import EventLocked
from tactiledata.diagnose.locate.locate import BESIDES, LEVEL, LocatorResults
from tactiledata.diagnose.locate.region_map import RegionMap
from tactiledata.diagnose.residuals.instruments import is_logarithmic, weighed_quantiles
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.slopes import Change
from tactiledata.diagnose.residuals.wording import p_text
from tactiledata.report.diagnosis_plots import Dependence, EventPicture, MapPicture, draw_shares
from tactiledata.report.page import Section
from tactiledata.report.panels import panels_of

MOST_CELLS = 40
"""Most cells of the residual's squares in a document."""


def findings(located: LocatorResults, most: int = 10) -> list[dict[str, Any]]:
    """Return the certain findings of each certain locator as rows of a document.

    A locator is certain where its p-value, corrected for the number of locators, is at most `LEVEL`; a finding is
    certain where its own p-value, which holds within its locator, is. A row holds ``locator`` (its name), ``p`` and
    ``words``, and what else the locator states, such as ``parameter`` and ``covariate``.

    Parameters
    ----------
    located : LocatorResults
        Results of all locators.
    most : int
        Most rows of one locator: the first ones in its own order.
    """
    rows: list[dict[str, Any]] = []
    for locator, listed in _by_locator(located):
        if located.is_certain(locator):
            rows += [{"locator": locator, **finding} for finding in listed if finding["p"] <= LEVEL][:most]
    return rows


def located_document(located: LocatorResults) -> dict[str, Any]:
    """Return the results of the locators as schemas/diagnosis.json has them (``located``)."""
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
    """Return a change of a parameter as schemas/diagnosis.json has it (``change``)."""
    share = change.value / abs(change.parameter.value) if change.is_relative else None
    width = change.half_width if np.isfinite(change.half_width) else None
    return {"value": change.value, "half_width": width, "unit": change.parameter.unit, "share": share}


def _drift_row(drift: Drift, begin: str = "") -> dict[str, Any]:
    """Return a drift as a row, with other words before its own where they are given."""
    return {
        "p": drift.p,
        "words": f"{begin}{drift.words}",
        "parameter": drift.parameter,
        "covariate": drift.covariate,
        "change": change_document(drift.change),
    }


def _by_locator(located: LocatorResults) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    """Yield the name of each locator with all its findings as rows."""
    if located.gate is not None:
        yield "size of the residual", [{"p": located.gate.p, "words": located.gate.words}]
    yield "free air", [{"p": located.free_air.p, "words": located.free_air.words}]
    # the strongest, then those that remain with it fitted, and then all as they are beside nothing
    strongest, beside = located.leading[:1], located.leading[1:]
    drifts = [_drift_row(drift) for drift in strongest] + [_drift_row(drift, BESIDES) for drift in beside]
    drifts += [_drift_row(drift) for drift in located.drifts if drift not in strongest]
    yield "drifting parameters", drifts
    yield "trajectories' own parameters", [_drift_row(drift) for drift in located.own]
    yield (
        "events",
        [
            {"p": event.p, "words": event.words, "event": event.event, "component": event.clusters[0].component}
            for event in located.events
            if event.clusters
        ],
    )
    # a contrast is of a parameter or of a component
    parameters = {parameter.name for parameter in located.projection.residuals.parameters}
    yield (
        "contrasts",
        [
            {
                "p": contrast.p,
                "words": contrast.words,
                "parameter" if contrast.what in parameters else "component": contrast.what,
                "covariate": contrast.along,
            }
            for contrast in located.contrasts
        ],
    )
    yield "the map", [{"p": region.p, "words": region.words, "parameter": region.parameter} for region in located.maps]
    facts = {LOCATORS[name].title: LOCATORS[name].facts for name in LOCATORS}
    for title, listed in located.by_table.items():
        yield title, [{"p": finding.p, "words": finding.words, **_row(facts[title](finding))} for finding in listed]


def _row(facts: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a finding as JSON values."""
    return {name: change_document(value) if isinstance(value, Change) else value for name, value in facts.items()}


BINS = 7
"""Bins of a covariate, of equal information."""


@dataclass(frozen=True)
class Binned:
    """Departures of one parameter in b bins of a covariate.

    Parameters
    ----------
    places : (b,)
        Weighted means of the covariate in the bins.
    departures, errors : (b,)
        Departures of the parameter, in its unit, with standard errors over the units of exchange.
    """

    places: Array
    departures: Array
    errors: Array


def dependence(projection: ProjectedResiduals, parameter: str, covariate: str) -> Binned:
    """Return the departure of a shared parameter from its refitted value that the data of each bin alone imply.

    At most `BINS` bins of the covariate hold equal shares of what the data say of the parameter.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals after the refit.
    parameter, covariate : str
        Names of the parameter and of the covariate.
    """
    residuals = projection.residuals
    names = [residuals.parameters[place].name for place in residuals.shared]
    place = names.index(parameter)
    values, weights = residuals.covariates[covariate].values, projection.information(place)
    # bins of equal information
    borders = np.unique(weighed_quantiles(values, weights, np.arange(1, BINS) / BINS))
    bins = (np.digitize(values, borders)[:, None] == np.arange(len(borders) + 1)).astype(np.float64)
    score = np.einsum("nk,nk->n", projection.directions[:, :, place], projection.score)
    information = residuals.by_unit(bins * weights[:, None])
    scores = residuals.by_unit(bins * score[:, None])
    # departures, and standard errors from what the units disagree on
    total = information.sum(axis=0)
    kept = total > 0
    total = total[kept]
    departures = scores.sum(axis=0)[kept] / total
    misfit = scores[:, kept] - departures * information[:, kept]
    places = ((bins * weights[:, None]).T @ values)[kept] / total
    return Binned(places, departures, np.sqrt((misfit**2).sum(axis=0)) / total)


DEPENDENCE_CAPTION = (
    "How far a parameter departs from its mean, by each part of the data alone. Vertical bars are standard errors. "
    "Where nothing is missing, all squares lie at 0."
)
MAP_CAPTION = "How far a parameter departs from its mean over the plane. Crosses lie outside the band of chance."
MOST_BARS = 24
"""Most bars in the picture of the residual's squares."""


def locators_section(located: LocatorResults, most: int = 10) -> Section:
    """Return the section with the p-values of all locators, and at most ``most`` findings of each."""
    rows = [(name, p_text(p), "yes" if p <= LEVEL else "no") for name, p in located.p.items()]
    sentences = [("", f"{finding['locator']}: {finding['words']}") for finding in findings(located, most)]
    text = (
        "A locator is a test that asks where predictions and measurements differ; p is the probability of a result at "
        "least as strong where nothing is missing. The p-values of the table hold for all locators together: where "
        "nothing is missing, one page in twenty says yes anywhere. The p-value of a finding holds within its locator. "
        "A finding may repeat another one; the sentences at the top leave out such repeats."
    )
    return Section("Where they differ", [("info", text), *sentences], ("locator", "p", "certain"), rows)


def shares_section(located: LocatorResults) -> Section | None:
    """Return the section of a page that says which parts of the data hold the excess of the squared residual.

    The residual is the whitened one after the refit of the shared parameters. Its excess is the sum of its squares
    minus what noise explains; where the noise is not known, it is the whole sum. The section has a sentence on the part
    that holds most of it (`EnergyShares.words`) and a picture of at most ``MOST_BARS`` bars. A bar is the share of the
    excess, cut off at 1, in one part: a component or a few together, a level of a label such as phase or indenter, or a
    third of a covariate such as depth. A tick is the share of all values that lie in the part. Parts that exceed an
    even spread most come first, and parts overlap, so that the bars do not add up to 1.

    It is ``None`` where the locators found no part: the excess is not positive, its 95 % interval includes 0, or the
    data have no conditions by which to divide them.

    Parameters
    ----------
    located : LocatorResults
        Results of the locators; their ``energy`` is shown.
    """
    cells = sorted(located.energy.cells, key=lambda cell: cell.of_values - cell.share)[:MOST_BARS]
    if not cells:
        return None
    drawn = draw_shares([c.words for c in cells], [min(c.share, 1.0) for c in cells], [c.of_values for c in cells])
    picture = panels_of(drawn, "Shares of the squared residual; ticks show an even spread.")
    return Section("Where the residual is largest", [("", located.energy.words)], pictures=[picture])


def dependence_panel(projection: ProjectedResiduals, after: ProjectedResiduals | None, drift: Drift) -> Dependence:
    """Return the panel of a drift: departures in bins of its covariate before and, where given, after.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals before.
    after : ProjectedResiduals, optional
        Residuals with an effect or a formula.
    drift : Drift
        Its parameter and covariate are drawn.
    """
    residuals = projection.residuals
    covariate = residuals.covariates[drift.covariate]
    scale, unit = 1.0, drift.change.parameter.unit
    if drift.change.is_relative:
        scale, unit = 100.0 / abs(drift.change.parameter.value), "%"
    before = dependence(projection, drift.parameter, drift.covariate)
    other = None if after is None else dependence(after, drift.parameter, drift.covariate)
    return Dependence(
        drift.parameter if unit in ("", "1") else f"{drift.parameter}, {unit}",
        drift.covariate if covariate.unit in ("", "1", "?") else f"{drift.covariate}, {covariate.unit}",
        is_logarithmic(covariate.values),
        before.places,
        scale * before.departures,
        scale * before.errors,
        # bins after differ from those before: they are drawn at the places of those before
        None if other is None else scale * np.interp(before.places, other.places, other.departures),
        None if other is None else scale * np.interp(before.places, other.places, other.errors),
    )


def event_picture(
    event: EventLocked, components: tuple[str, ...], note: str = "", scale: str = "times the noise"
) -> EventPicture:
    """Return the picture of the mean residual about an event.

    Parameters
    ----------
    event : EventLocked
        Means about one kind of event; all k components are drawn.
    components : tuple of str
        Names of all k components of the residual, in the order of the columns of ``event.mean``.
    note : str
        Follows the name of the event in the title as it is, its separator included, such as ``", plain"``.
    scale : str
        Unit of the residual, for the axis, as `Residuals.scale` has it; no value is converted.
    """
    return EventPicture(f"{event.event}{note}", event.frames, event.mean, event.deviation, components, scale)


def map_picture(region: RegionMap, note: str = "") -> MapPicture:
    """Return the picture of a map; departures are in per cent where the parameter's value is known.

    Places where the statistic lies outside the band of chance are marked.

    Parameters
    ----------
    region : RegionMap
        Map of one parameter over the gel.
    note : str
        Follows the name of the parameter in the title as it is, its separator included, such as ``", plain"``.
    """
    parameter, scale, unit = region.change.parameter, 1.0, region.change.parameter.unit
    if region.change.is_relative:
        scale, unit = 100.0 / abs(parameter.value), "%"
    return MapPicture(
        f"{region.parameter}{note}", f"x, {region.unit}", f"y, {region.unit}", unit, region.x, region.y,
        scale * region.departure, np.abs(region.statistic) > region.band,
    )  # fmt: skip
