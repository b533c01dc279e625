"""A diagnosis as a page to read: sentences first, then what they rest on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tactiledata.diagnose.dependence import dependence
from tactiledata.diagnose.explain import Explanation
from tactiledata.diagnose.findings import findings
from tactiledata.diagnose.instability import Drift
from tactiledata.diagnose.ladder import is_logarithmic
from tactiledata.diagnose.locate import LEVEL, Located
from tactiledata.diagnose.projection import Projection, project
from tactiledata.diagnose.wording import percent, rounded
from tactiledata.report.diagnosis_plots import (
    Dependence,
    EventPicture,
    MapPicture,
    draw_dependences,
    draw_errors,
    draw_events,
    draw_map,
    draw_shares,
)
from tactiledata.report.page import Picture, Section, render_page
from tactiledata.report.plots import png_bytes

MOST_PANELS = 6
MOST_BARS = 24


def explanation_page(
    title: str, explanation: Explanation, errors: Sequence[dict[str, Any]], notes: Sequence[str], footer: str
) -> str:
    """The page as HTML.

    Parameters
    ----------
    errors : rows of ``component, unit, before, after``
    notes : what was left out
    """
    sections = [_locators(explanation.located), *_formula(explanation, errors), *_pictures(explanation)]
    if notes:
        sections.append(Section("What was left out", [("warning", note) for note in notes]))
    return render_page(title, explanation.sentences(), sections, footer)


def _locators(located: Located) -> Section:
    rows = [(name, f"{p:.3g}", "yes" if p <= LEVEL else "no") for name, p in located.p.items()]
    said = [("", f"{one['locator']}: {one['words']}") for one in findings(located)]
    text = "p-values hold for all locators together: where nothing is missing, one page in twenty says yes anywhere."
    return Section("Where they differ", [("info", text), *said], ("locator", "p", "certain"), rows)


def _formula(explanation: Explanation, errors: Sequence[dict[str, Any]]) -> list[Section]:
    form = explanation.form
    if form is None:
        return []
    rows = [
        (
            f"{term.carrier}: {term.term}",
            f"{rounded(term.coefficient, 3)} ± {rounded(term.half_width)}",
            percent(term.inclusion),
            f"{term.p:.3g}",
            "; ".join(term.alike) or "-",
        )
        for term in form.terms
    ]
    text = (
        f"{form.candidates} terms without dimension were tried. Halves of the groups chose these again and again; of "
        f"such choices at most {rounded(form.false_terms)} are expected to be false before they are tested."
    )
    columns = ("term", "coefficient", "chosen by", "p", "cannot be told from")
    sections = [Section("As a formula", [("", form.words), ("info", text)], columns, rows)]
    if errors:
        said = [(one["component"], one["unit"], rounded(one["before"], 3), rounded(one["after"], 3)) for one in errors]
        headings = ("", "unit", "error before", "error with the formula")
        text = "Root mean squares on groups that had no part in choosing or fitting the formula."
        sections.append(Section("How much better", [("info", text)], headings, said, _bars(explanation)))
    return sections


def _bars(explanation: Explanation) -> list[Picture]:
    gap, ceiling = explanation.gap, explanation.ceiling
    if gap is None:
        return []
    counts = explanation.located.projection.left.size
    black_box = float(np.sqrt(ceiling.squares.sum() / counts))
    names = ["as predicted", "with the formula", "black box", f"floor: {explanation.floor_is}"]
    drawn = draw_errors(names, [gap.before, gap.after, black_box, gap.floor])
    return [Picture(png_bytes(drawn), "Errors of groups that had no part in formula or black box, and the floor.")]


def _pictures(explanation: Explanation) -> list[Section]:
    located, form = explanation.located, explanation.form
    after = None
    if form is not None and form.terms:
        after = project(located.projection.residuals.with_fields(form.fields))
    sections = []
    panels = [_panel(located.projection, after, drift) for drift in _drawn(located)]
    if panels:
        picture = Picture(png_bytes(draw_dependences(panels)), "What each part of the data alone says of a parameter.")
        sections.append(Section("Dependences", pictures=[picture]))
    pictures = [
        EventPicture(one.event, one.frames, one.mean, one.deviation, located.projection.residuals.components)
        for one in located.events[:MOST_PANELS]
    ]
    if pictures:
        picture = Picture(png_bytes(draw_events(pictures)), "Means over groups, the mean before the event taken off.")
        sections.append(Section("About events", pictures=[picture]))
    cells = sorted(located.energy.cells, key=lambda cell: cell.of_values - cell.share)[:MOST_BARS]
    if cells:
        drawn = draw_shares([c.words for c in cells], [c.share for c in cells], [c.of_values for c in cells])
        picture = Picture(png_bytes(drawn), "Shares of the squared residual; ticks show an even spread.")
        sections.append(Section("Where the squares sit", [("", located.energy.words)], pictures=[picture]))
    if located.maps:
        first = located.maps[0]
        mapped = MapPicture(
            first.parameter, f"x, {first.unit}", f"y, {first.unit}", first.change.parameter.unit, first.x, first.y,
            first.departure, np.abs(first.statistic) > first.band,
        )  # fmt: skip
        picture = Picture(png_bytes(draw_map(mapped)), "Dots: outside the band of chance.")
        sections.append(Section("Map", [("", first.words)], pictures=[picture]))
    return sections


def _drawn(located: Located) -> list[Drift]:
    """The drifts over covariates, the strongest first, those over labels left out."""
    covariates = located.projection.residuals.covariates
    return [drift for drift in located.drifts if drift.covariate in covariates][:MOST_PANELS]


def _panel(projection: Projection, after: Projection | None, drift: Drift) -> Dependence:
    residuals = projection.residuals
    covariate = residuals.covariates[drift.covariate]
    scale, unit = 1.0, drift.change.parameter.unit
    if drift.change.is_relative:
        scale, unit = 100.0 / abs(drift.change.parameter.value), "%"
    one = dependence(projection, drift.parameter, drift.covariate)
    other = None if after is None else dependence(after, drift.parameter, drift.covariate)
    return Dependence(
        f"{drift.parameter}, {unit}",
        f"{drift.covariate}, {covariate.unit}",
        is_logarithmic(covariate.values),
        one.places,
        scale * one.departures,
        scale * one.errors,
        None if other is None else scale * other.departures,
        None if other is None else scale * other.errors,
    )
