"""What locators found as rows: for documents, tables and pages alike."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from tactiledata.diagnose.locate import LEVEL, Located
from tactiledata.diagnose.slopes import Change

MOST_CELLS = 40


def findings(located: Located, most: int = 10) -> list[dict[str, Any]]:
    """The certain findings of each locator that is certain among all, at most so many of each."""
    rows: list[dict[str, Any]] = []
    for locator, listed in _by_locator(located):
        if located.is_certain(locator):
            rows += [{"locator": locator, **one} for one in listed if one["p"] <= LEVEL][:most]
    return rows


def located_document(located: Located) -> dict[str, Any]:
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


def _by_locator(located: Located) -> Iterator[tuple[str, list[dict[str, Any]]]]:
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
