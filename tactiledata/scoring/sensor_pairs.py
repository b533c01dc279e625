"""Scores of one sensor's pictures against another's, on the full frame and where they show the touch."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UnknownName
from tactiledata.metrics import METRICS
from tactiledata.metrics.base import Score
from tactiledata.metrics.bootstrap import Interval, bootstrap
from tactiledata.scoring.sensor_sets import SensorSet, contact_masks, load_pictures
from tactiledata.store.reader import Store

Pictures = NDArray[np.uint8]
Masks = NDArray[np.bool_]
Progress = Callable[..., None]


@dataclass(frozen=True)
class PairScore:
    """One score of one pair.

    ``first`` was scored against ``second``; the interval draws the trajectories of ``first``. ``is_synthetic`` says
    whether ``first`` was made by a transfer: the paper's column Synth., else its column Real.
    """

    metric: str
    score: Score
    first: str
    second: str
    is_synthetic: bool
    region: str
    interval: Interval

    def document(self) -> dict[str, Any]:
        """As JSON."""
        facts = {name: getattr(self, name) for name in ("metric", "first", "second", "is_synthetic", "region")}
        about = {name: getattr(self.score, name) for name in ("name", "title", "unit", "better")}
        return {**facts, "score": about, **vars(self.interval)}


def set_scores(names: Sequence[str]) -> list[tuple[str, Score]]:
    """Scores of whole sets of pictures, each with its metric's name: those of these names, or of metrics so called.

    Raises
    ------
    UnknownName
        Neither a score nor a metric of sets of pictures.
    """
    able = {name: METRICS[name].scores for name in METRICS if METRICS[name].takes == "image sets"}
    found: dict[tuple[str, str], Score] = {}
    for wanted in names:
        chosen = [(metric, name) for metric, scores in able.items() for name in scores if wanted in (metric, name)]
        if not chosen:
            known = {*able, *(name for scores in able.values() for name in scores)}
            raise UnknownName(
                "score of sets of pictures",
                wanted,
                known,
                "Pictures that have a truth beside them are scored by `tactiledata evaluate RECIPE`.",
            )
        found.update({key: able[key[0]][key[1]] for key in chosen})
    return [(metric, score) for (metric, _), score in found.items()]


def score_pairs(
    store: Store,
    scores: Sequence[tuple[str, Score]],
    sets: Sequence[SensorSet],
    against: Sequence[str] | None = None,
    progress: Progress | None = None,
) -> Iterator[PairScore]:
    """Scores of all pairs of sets, or of all sets against the named ones.

    Two sets' pictures are in memory at once. A score is handed both sets, and for the second time both sets' masks of
    where the pictures show their touches, if both sensors have a picture without contact.
    """
    pairs = list(_pairs(sets, against))
    loaded: dict[str, tuple[Pictures, Masks | None]] = {}
    for done, (first, second) in enumerate(pairs, start=1):
        for gone in set(loaded) - {first.name, second.name}:
            del loaded[gone]
        for one in (first, second):
            if one.name not in loaded:
                pictures = load_pictures(store, one)
                loaded[one.name] = pictures, contact_masks(store, one, pictures)
        yield from _scored(scores, first, second, loaded[first.name], loaded[second.name])
        if progress is not None:
            progress(done, len(pairs), f"{first.name} and {second.name}")


def _pairs(sets: Sequence[SensorSet], against: Sequence[str] | None) -> Iterator[tuple[SensorSet, SensorSet]]:
    for number, one in enumerate(sets):
        for other in sets if against is not None else sets[number + 1 :]:
            if other is not one and (against is None or other.name in against):
                yield one, other


def _scored(
    scores: Sequence[tuple[str, Score]],
    first: SensorSet,
    second: SensorSet,
    ours: tuple[Pictures, Masks | None],
    theirs: tuple[Pictures, Masks | None],
) -> Iterator[PairScore]:
    for metric, score in scores:
        facts = (metric, score, first.name, second.name, first.is_derived)
        yield PairScore(*facts, "frame", bootstrap(score(ours[0], theirs[0]), first.trajectories))
        if ours[1] is None or theirs[1] is None or not (ours[1].any() and theirs[1].any()):
            continue
        inside = score(ours[0], theirs[0], (ours[1], theirs[1]))
        yield PairScore(*facts, "contact", bootstrap(inside, first.trajectories))
