"""Scores that a person asked for by name, of sets of pictures or of latent vectors; never two scales in one table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from tactiledata.errors import UnknownName, UsageError
from tactiledata.metrics import METRICS
from tactiledata.metrics.base import Score

OF_SETS = ("image sets", "latent sets")
STYLE = "gram_style"
TSNE = "tsne"
"""Not a score but a picture; its quantitative companions are those of the metric ``embedding``."""


def chosen_scores(names: Sequence[str], weights: Path | None = None) -> list[tuple[str, Score]]:
    """Scores of sets, each with the name of its metric.

    A name is a score's, or a metric's for all its scores. ``gram_style`` is the distance by VGG-19's official weights
    where they are found, else by the labelled random network: one of the two, never both.

    Parameters
    ----------
    names : list of str
    weights : Path, optional
        Official weights of VGG-19; those in PyTorch's cache by default.

    Raises
    ------
    UnknownName
        Nothing goes by that name.
    UsageError
        Both style distances in one table.
    MissingFile
        No weights where they were said to be.
    """
    able = {name: METRICS[name].scores for name in METRICS if METRICS[name].takes in OF_SETS}
    found: dict[str, tuple[str, Score]] = {}
    for wanted in names:
        for metric, score in _named(wanted, able, weights):
            found[score.name] = (metric, score)
    if {STYLE, f"{STYLE}_random"} <= set(found):
        raise UsageError(
            "style distances by VGG-19 and by random features in one table",
            "one of them: their numbers cannot be compared",
            f"Ask for {STYLE} alone: it takes VGG-19 where its weights are found.",
        )
    return list(found.values())


def _named(wanted: str, able: dict[str, Any], weights: Path | None) -> list[tuple[str, Score]]:
    if wanted == STYLE:
        from tactiledata.metrics.gram_style import style_score

        score = able[STYLE][style_score(weights)]
        return [(STYLE, replace(score, compute=partial(score.compute, weights=weights)) if weights else score)]
    if wanted == TSNE:
        return [("embedding", score) for score in able["embedding"].values()]
    if wanted in able:
        return [(wanted, score) for score in able[wanted].values()]
    found = [(metric, scores[wanted]) for metric, scores in able.items() if wanted in scores]
    if not found:
        known = {TSNE, *able, *(name for scores in able.values() for name in scores)}
        raise UnknownName(
            "score of two sets",
            wanted,
            known,
            "Pictures that have a truth beside them are scored by `tactiledata evaluate RECIPE`.",
        )
    return found
