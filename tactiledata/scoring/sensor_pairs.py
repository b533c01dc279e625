"""Scores of one sensor's touches against another's: pictures, their contacts, and what they are encoded to."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import PictureArray
from tactiledata.contract.progress import Progress
from tactiledata.metrics import METRICS
from tactiledata.metrics.base import Score
from tactiledata.metrics.bootstrap import Interval, bootstrap
from tactiledata.scoring.sensor_sets import SensorSet, background_of, contact_masks, load_pictures
from tactiledata.store.read.reader import Store

Vectors = Mapping[str, NDArray[np.floating]]
Encode = Callable[[PictureArray, PictureArray | None], Vectors]
"""Latent vectors (n, d) by name, of pictures (n, H, W, 3) of a sensor and its picture without contact, if there is."""


@dataclass(frozen=True)
class Touches:
    """What a set is scored by."""

    pictures: PictureArray
    masks: NDArray[np.bool_] | None
    vectors: Vectors


@dataclass(frozen=True)
class PairScore:
    """One score of one pair.

    ``first`` was scored against ``second``; the interval draws the trajectories of ``first``. ``first_kind`` and
    ``second_kind`` say what each is: recorded, a simulated recording, synthetic, or a picture without contact.
    ``looked_at``: the whole ``frame``, the ``contact``, all ``outside the contact``, or the name of the latent vectors.
    """

    metric: str
    score: Score
    first: str
    second: str
    first_kind: str
    second_kind: str
    looked_at: str
    interval: Interval

    def document(self) -> dict[str, Any]:
        """The score as JSON values."""
        names = ("metric", "first", "second", "first_kind", "second_kind", "looked_at")
        facts = {name: getattr(self, name) for name in names}
        about = {name: getattr(self.score, name) for name in ("name", "title", "unit", "better")}
        numbers = {name: _finite(value) for name, value in vars(self.interval).items()}
        return {**facts, "score": about, **numbers}


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def load_touches(store: Store, one: SensorSet, encode: Encode | None = None) -> Touches:
    """Pictures of a set, masks of their contacts, and their latent vectors."""
    pictures = load_pictures(store, one)
    background = background_of(store, one)
    vectors = encode(pictures, background) if encode is not None else {}
    return Touches(pictures, contact_masks(pictures, background), vectors)


def score_pairs(
    store: Store,
    scores: Sequence[tuple[str, Score]],
    sets: Sequence[SensorSet],
    against: Sequence[str] | None = None,
    encode: Encode | None = None,
    progress: Progress | None = None,
) -> Iterator[PairScore]:
    """Scores of all pairs of sets, or of all sets against the named ones; two sets are in memory at once.

    Scores of pictures look at the whole frame, and at the contact where both sensors have a picture without contact;
    scores of latent vectors at each kind of vector.
    """
    pairs = list(_pairs(sets, against))
    loaded: dict[str, Touches] = {}
    for done, (first, second) in enumerate(pairs, start=1):
        for gone in set(loaded) - {first.name, second.name}:
            del loaded[gone]
        for one in (first, second):
            if one.name not in loaded:
                loaded[one.name] = load_touches(store, one, encode)
        for metric, score in scores:
            for looked_at, values in _values(metric, score, loaded[first.name], loaded[second.name]):
                interval = bootstrap(values, first.trajectories)
                kinds = first.kind, second.kind
                yield PairScore(metric, score, first.name, second.name, *kinds, looked_at, interval)
        if progress is not None:
            progress(done, len(pairs), f"{first.name} and {second.name}")


def _pairs(sets: Sequence[SensorSet], against: Sequence[str] | None) -> Iterator[tuple[SensorSet, SensorSet]]:
    for number, one in enumerate(sets):
        for other in sets if against is not None else sets[number + 1 :]:
            if other is not one and (against is None or other.name in against):
                yield one, other


def _values(metric: str, score: Score, ours: Touches, theirs: Touches) -> Iterator[tuple[str, NDArray[np.float64]]]:
    if METRICS[metric].takes == "latent sets":
        for name in ours.vectors:
            if name in theirs.vectors:
                yield name, score.compute(ours.vectors[name], theirs.vectors[name])
        return
    yield "frame", score.compute(ours.pictures, theirs.pictures)
    if ours.masks is not None and theirs.masks is not None and ours.masks.any() and theirs.masks.any():
        yield "contact", score.compute(ours.pictures, theirs.pictures, ours.masks, theirs.masks)
