"""A diagnosis as a page to read: sentences first, then what they rest on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tactiledata.diagnose.answer.locator_rows import (
    dependence_panel,
    event_picture,
    locators_section,
    map_picture,
    shares_section,
)
from tactiledata.diagnose.formula.explain import Explanation
from tactiledata.diagnose.formula.open_form import corrected_words
from tactiledata.diagnose.locate.drifts import Drift
from tactiledata.diagnose.locate.locate import LocatorResults
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.wording import percent, rounded
from tactiledata.report.diagnosis_plots import draw_dependences, draw_errors, draw_events, draw_map
from tactiledata.report.page import Picture, Section, render_page
from tactiledata.report.plots import png_bytes

MOST_PANELS = 6
REFITTED = "scale and offset refitted"


def explanation_page(
    title: str, explanation: Explanation, errors: Sequence[dict[str, Any]], notes: Sequence[str], footer: str
) -> str:
    """The page as HTML.

    Parameters
    ----------
    errors : rows of ``component, unit, before, after``
    notes : what was left out
    """
    sections = [locators_section(explanation.located), *_formula(explanation, errors), *_pictures(explanation)]
    if notes:
        sections.append(Section("What was left out", [("warning", note) for note in notes]))
    return render_page(title, explanation.sentences(), sections, footer)


def _formula(explanation: Explanation, errors: Sequence[dict[str, Any]]) -> list[Section]:
    form = explanation.form
    if form is None:
        return []
    residuals = explanation.located.projection.residuals
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
        f"{form.candidates} terms without dimension were tried. Halves of the groups chose these again and again: "
        f"where nothing is to be found, at most {rounded(form.false_terms)} terms are, and each was tested after that."
    )
    columns = ("term", "coefficient", "chosen by", "p", "cannot be told from")
    said = [
        ("", form.words),
        *(("", line) for line in corrected_words(form, residuals.components, residuals.units)),
        *(("", f"Here {line}.") for line in form.definitions),
        ("info", text),
    ]
    sections = [Section("As a formula", said, columns, rows)]
    if errors:
        cells = [(one["component"], one["unit"], rounded(one["before"], 3), rounded(one["after"], 3)) for one in errors]
        headings = ("", "unit", REFITTED, "with the formula")
        text = (
            "Root mean squares on groups that had no part in choosing or fitting the formula. Before it, scale and "
            "offset of each prediction are refitted already: a common factor is no formula."
        )
        sections.append(Section("How much better", [("info", text)], headings, cells, _bars(explanation)))
    return sections


def _bars(explanation: Explanation) -> list[Picture]:
    gap, ceiling = explanation.gap, explanation.ceiling
    if gap is None:
        return []
    counts = explanation.located.projection.left.size
    black_box = float(np.sqrt(ceiling.squares.sum() / counts))
    names = [REFITTED, "with the formula", "black box", f"floor: {explanation.floor_is}"]
    scale = explanation.located.projection.residuals.scale
    drawn = draw_errors(names, [gap.before, gap.after, black_box, gap.floor], scale)
    return [Picture(png_bytes(drawn), "Errors of groups that had no part in formula or black box, and the floor.")]


def _pictures(explanation: Explanation) -> list[Section]:
    located, form = explanation.located, explanation.form
    after = None
    if form is not None and form.terms:
        after = project(located.projection.residuals.with_fields(form.fields))
    sections = []
    panels = [dependence_panel(located.projection, after, drift) for drift in _drawn(located)]
    if panels:
        picture = Picture(png_bytes(draw_dependences(panels)), "What each part of the data alone says of a parameter.")
        sections.append(Section("Dependences", pictures=[picture]))
    components, scale = located.projection.residuals.components, located.projection.residuals.scale
    pictures = [event_picture(one, components, scale=scale) for one in located.events[:MOST_PANELS]]
    if pictures:
        picture = Picture(png_bytes(draw_events(pictures)), "Means over groups, the mean before the event taken off.")
        sections.append(Section("About events", pictures=[picture]))
    shares = shares_section(located)
    sections += [shares] if shares is not None else []
    if located.maps:
        first = located.maps[0]
        picture = Picture(png_bytes(draw_map(map_picture(first))), "Dots: outside the band of chance.")
        sections.append(Section("Map", [("", first.words)], pictures=[picture]))
    return sections


def _drawn(located: LocatorResults) -> list[Drift]:
    """The drifts over covariates, the strongest first, those over labels left out."""
    covariates = located.projection.residuals.covariates
    return [drift for drift in located.drifts if drift.covariate in covariates][:MOST_PANELS]
