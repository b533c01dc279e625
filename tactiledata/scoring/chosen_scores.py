"""Scores of two sets that a person names, of pictures or of latent vectors; a table never mixes two scales."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from tactiledata.errors import UnknownName, UsageError
from tactiledata.metrics import METRICS
from tactiledata.metrics.base import Score

VECTORS = "latent sets"
"""Kind of metrics that compare sets of latent vectors."""
OF_SETS = ("image sets", VECTORS)
"""Kinds of metrics that compare two sets."""
STYLE = "gram_style"
"""Name by which a person asks for a style distance."""
KEPT = "kept_touch"
"""Metric of a synthetic set and what it was made of: scored for every such set, whether a person asks for it or not."""
TSNE = "tsne"
"""Name of the picture of latent vectors; the scores that go with it are those of the metric ``embedding``."""


def chosen_scores(names: Sequence[str], weights: Path | None = None, device: str = "cpu") -> list[tuple[str, Score]]:
    """Return the named scores of sets, each with the name of its metric.

    A name is that of a score, or of a metric for all its scores. ``gram_style`` is the distance by the official weights
    of VGG-19 where they are found, else by the random network: one of the two, never both.

    Parameters
    ----------
    names : list of str
        Names of scores or metrics, or ``tsne``; ``kept_touch`` is left out, as it compares no two sets.
    weights : Path, optional
        Official weights of VGG-19; those in PyTorch's cache by default.
    device : str
        PyTorch's name of the device that the network of a style distance runs on.

    Raises
    ------
    UnknownName
        A name of no score and no metric of sets.
    UsageError
        Both style distances in one table.
    MissingFile
        No file at ``weights``.
    """
    able = {name: METRICS[name].scores for name in METRICS if METRICS[name].takes in OF_SETS}
    chosen: dict[str, tuple[str, Score]] = {}
    for name in names:
        if name == KEPT:
            continue
        for metric, score in _named(name, able, weights, device):
            chosen[score.name] = (metric, score)
    if {STYLE, f"{STYLE}_random"} <= set(chosen):
        raise UsageError(
            "style distances by VGG-19 and by random features in one table",
            "one of them: their numbers cannot be compared",
            f"Ask for {STYLE} alone: it takes VGG-19 where its weights are found.",
        )
    return list(chosen.values())


def needs_vectors(names: Sequence[str], scores: Sequence[tuple[str, Score]]) -> bool:
    """Whether latent vectors have a part: for the picture of them, or for a score.

    Parameters
    ----------
    names : list of str
        As `chosen_scores` takes them.
    scores : list of (str, Score)
        As `chosen_scores` returns them.
    """
    return TSNE in names or any(METRICS[metric].takes == VECTORS for metric, _ in scores)


def _named(name: str, able: dict[str, Any], weights: Path | None, device: str) -> list[tuple[str, Score]]:
    """Return the scores that one name stands for, each with the name of its metric.

    Parameters
    ----------
    name : str
        Name of a score or a metric, or ``tsne``.
    able : dict, metric -> dict of Score
        Scores of all metrics of sets.
    weights : Path, optional
        Official weights of VGG-19.
    device : str
        Device of the network of a style distance.
    """
    if name == STYLE:
        from tactiledata.metrics.gram_style import style_score

        score = able[STYLE][style_score(weights)]
        stated = {"device": device, **({"weights": weights} if weights else {})}
        return [(STYLE, replace(score, compute=partial(score.compute, **stated)))]
    if name == TSNE:
        return [("embedding", score) for score in able["embedding"].values()]
    if name in able:
        return [(name, score) for score in able[name].values()]
    matches = [(metric, scores[name]) for metric, scores in able.items() if name in scores]
    if not matches:
        known = {TSNE, KEPT, *able, *(key for scores in able.values() for key in scores)}
        raise UnknownName(
            "score of two sets",
            name,
            known,
            "Pictures that have a truth beside them are scored by `tactiledata evaluate RECIPE`.",
        )
    return matches
