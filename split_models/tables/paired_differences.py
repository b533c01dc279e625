"""Rows that say by how much methods differ on the same frames: what a sentence needs before it says "ahead"."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from split_models.tables.evaluate import Values, summarised
from tactiledata.metrics.base import Score

DIFFERENCE = "less"
"""Word between a part and the reference in the title of a part with differences."""


def differences(values: Mapping[str, Values], reference: str) -> dict[str, Values]:
    """Scores of each method less those of a reference on the same frames, by method.

    A frame on which either has no finite value has none: a picture that is equal to the truth has an infinite PSNR.

    Parameters
    ----------
    values : dict of Values
        Scores (n,) by name, by method; the order of the frames is the same for all.
    reference : str
        Name of the method that the others are compared with.

    Returns
    -------
    dict of Values
        Nothing where the reference is not among the methods.
    """
    if reference not in values:
        return {}
    base = values[reference]
    found: dict[str, Values] = {}
    for method, scores in values.items():
        if method == reference:
            continue
        shared = {name: (scores[name], base[name]) for name in scores if name in base}
        found[method] = {name: _less(ours, theirs) for name, (ours, theirs) in shared.items()}
    return found


def difference_part(part: str, title: str) -> str:
    """Title of the part with each row's difference to a reference that has a title."""
    return f"{part}, each row {DIFFERENCE} {title}"


def difference_rows(
    part: str,
    values: Mapping[str, Values],
    reference: str,
    title: str,
    trajectories: Any,
    rounds: int,
    known: Mapping[str, Score],
) -> list[dict[str, Any]]:
    """A row for each method but the reference: mean difference of each score, with an interval over trajectories.

    Parameters
    ----------
    part : str
        Part of the split.
    values : dict of Values
        Scores (n,) by name, by method.
    reference, title : str
        Method that the others are compared with, and its title for people.
    trajectories : (n,) str
        Trajectory of each frame.
    rounds : int
        Rounds of the bootstrap.
    known : dict of Score
        Unit and direction of each score.
    """
    return [
        {
            "part": difference_part(part, title),
            "method": method,
            "scores": summarised(less, trajectories, rounds, known),
        }
        for method, less in differences(values, reference).items()
    ]


def _less(ours: Any, theirs: Any) -> Any:
    """Differences (n,), NaN where either is not finite."""
    is_finite = np.isfinite(ours) & np.isfinite(theirs)
    return np.where(is_finite, np.where(is_finite, ours, 0.0) - np.where(is_finite, theirs, 0.0), np.nan)
