"""The page of a table's diagnosis: sentences first, then the tables and pictures behind them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tactiledata.diagnose.answer.glossary import FIRST, with_explanations
from tactiledata.diagnose.answer.locator_rows import (
    DEPENDENCE_CAPTION,
    MAP_CAPTION,
    dependence_panel,
    event_picture,
    locators_section,
    map_picture,
    shares_section,
)
from tactiledata.diagnose.formula.explain import Explanation
from tactiledata.diagnose.formula.open_form import corrected_words
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.wording import percent, rounded
from tactiledata.report.diagnosis_plots import Dependence, draw_dependences, draw_errors, draw_events, draw_map
from tactiledata.report.page import Picture, Section, render_page
from tactiledata.report.panels import panels_of

MOST_PANELS = 6
"""Most dependences, and most events, that are drawn."""
MOST_FIRST = 3
"""Most dependences in the picture at the top."""
REFITTED = "scale and offset refitted"


def explanation_page(
    title: str, explanation: Explanation, errors: Sequence[dict[str, Any]], notes: Sequence[str], footer: str
) -> str:
    """Return the page of a diagnosis as HTML.

    It begins with a picture of the mismatch and its cure, and with the answer in three sentences. All sentences and the
    sections are folded below.

    Parameters
    ----------
    title : str
    explanation : Explanation
    errors : sequence of dict
        ``component``, ``unit``, ``before`` and ``after`` of each component, on held-out groups.
    notes : sequence of str
        What was left out, and why.
    footer : str
    """
    sentences = explanation.sentences()
    details = [
        Section("All in words", with_explanations(sentences)),
        locators_section(explanation.located),
        *_formula(explanation, errors),
        *_pictures(explanation),
    ]
    if notes:
        details.append(Section("What was left out", [("warning", note) for note in notes]))
    sections = [replace(section, is_folded=True) for section in details]
    beginning = with_explanations(sentences[:FIRST])
    return render_page(title, beginning, sections, footer, first_picture=_first_picture(explanation))


def _formula(explanation: Explanation, errors: Sequence[dict[str, Any]]) -> list[Section]:
    """Return the sections with the formula and its errors on held-out groups; nothing where none was sought."""
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
        f"{form.candidates} dimensionless terms were tried. Random halves of the groups chose these again and again. "
        f"Where there is nothing to find, at most {rounded(form.false_terms)} terms are chosen so often. Each term was "
        "then tested against all candidates (p)."
    )
    columns = ("term", "coefficient", "chosen by", "p", "cannot be told from")
    sentences = [
        ("", form.words),
        *(("", line) for line in corrected_words(form, residuals.components, residuals.units)),
        *(("", f"Here {line}.") for line in form.definitions),
        ("info", text),
    ]
    sections = [Section("As a formula", sentences, columns, rows)]
    if errors:
        cells = [(row["component"], row["unit"], rounded(row["before"], 3), rounded(row["after"], 3)) for row in errors]
        headings = ("", "unit", REFITTED, "with the formula")
        text = (
            "Root mean squares on groups that had no part in choosing or fitting the formula. Scale and offset of each "
            "prediction are refitted without the formula, too: a common factor is no formula."
        )
        sections.append(Section("How much better", [("info", text)], headings, cells, _bars(explanation)))
    return sections


def _bars(explanation: Explanation) -> list[Picture]:
    """Return the picture of errors before and after, of the black box and of the floor; nothing without a gap."""
    gap, ceiling = explanation.gap, explanation.ceiling
    if gap is None:
        return []
    counts = explanation.located.projection.left.size
    black_box = float(np.sqrt(ceiling.squares.sum() / counts))
    names = [REFITTED, "with the formula", "black box", f"floor: {explanation.floor_is}"]
    scale = explanation.located.projection.residuals.scale
    drawn = draw_errors(names, [gap.before, gap.after, black_box, gap.floor], scale)
    return [panels_of(drawn, "Errors of groups that had no part in formula or black box.")]


def _pictures(explanation: Explanation) -> list[Section]:
    """Return the sections with dependences, events, shares of the residual and the map."""
    located = explanation.located
    # dependences on covariates
    sections = []
    panels = _dependence_panels(explanation, MOST_FIRST, MOST_PANELS)
    if panels:
        picture = panels_of(draw_dependences(panels), DEPENDENCE_CAPTION)
        sections.append(Section("More dependences", pictures=[picture]))
    # mean residuals about events
    components, scale = located.projection.residuals.components, located.projection.residuals.scale
    pictures = [event_picture(event, components, scale=scale) for event in located.events[:MOST_PANELS]]
    if pictures:
        picture = panels_of(draw_events(pictures), "Means over groups, less the mean before the event.")
        sections.append(Section("About events", pictures=[picture]))
    # where the residual is largest, and over which places it departs
    shares = shares_section(located)
    sections += [shares] if shares is not None else []
    if located.maps:
        first = located.maps[0]
        picture = panels_of(
            draw_map(map_picture(first)),
            MAP_CAPTION,
        )
        sections.append(Section("Map", [("", first.words)], pictures=[picture]))
    return sections


def _first_picture(explanation: Explanation) -> Picture | None:
    """Return the picture at the top: the strongest dependences, else the errors; nothing where there is neither."""
    panels = _dependence_panels(explanation, 0, MOST_FIRST)
    if panels:
        return panels_of(draw_dependences(panels), DEPENDENCE_CAPTION)
    bars = _bars(explanation)
    return bars[0] if bars else None


def _dependence_panels(explanation: Explanation, first: int, stop: int) -> list[Dependence]:
    """Return panels of some drifts over covariates, without and with the formula: from one place to another.

    The strongest drift is at place 0. Labels cannot be drawn as an axis.
    """
    located, form = explanation.located, explanation.form
    after = None
    if form is not None and form.terms:
        after = project(located.projection.residuals.with_fields(form.fields))
    covariates = located.projection.residuals.covariates
    drawn = [drift for drift in located.drifts if drift.covariate in covariates][first:stop]
    return [dependence_panel(located.projection, after, drift) for drift in drawn]
