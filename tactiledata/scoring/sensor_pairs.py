"""Scores of the touches of one sensor against those of another: pictures, contacts and latent vectors."""

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
"""Latent vectors (n, d) of n pictures, by kind."""
Encode = Callable[[PictureArray, PictureArray | None], Vectors]
"""Function that gives latent vectors by kind, for pictures (n, H, W, 3) of a sensor and its picture (H, W, 3) without
contact; the latter is None where it is not known."""


@dataclass(frozen=True)
class Touches:
    """Data of a set on which its scores rest.

    Parameters
    ----------
    pictures : (n, H, W, 3), uint8 RGB
        Pictures of the touches.
    masks : (n, H, W), bool, optional
        Where each picture shows its touch; None where the sensor has no picture without contact.
    vectors : dict, kind -> (n, d)
        Latent vectors of the pictures; empty without a function that encodes.
    """

    pictures: PictureArray
    masks: NDArray[np.bool_] | None
    vectors: Vectors


@dataclass(frozen=True)
class PairScore:
    """One score of one pair of sets.

    Parameters
    ----------
    metric : str
        Name of the metric.
    score : Score
        The score.
    first, second : str
        Names of the sets: ``first`` was scored against ``second``.
    first_kind, second_kind : str
        What each set is: recorded, a simulated recording, synthetic, or a picture without contact.
    looked_at : str
        What was compared: the ``frame``, the ``contact``, ``outside the contact``, or the kind of latent vectors.
    interval : Interval
        Mean of the score, with the interval over the trajectories of ``first``.
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
        """Return the score as values for JSON."""
        names = ("metric", "first", "second", "first_kind", "second_kind", "looked_at")
        facts = {name: getattr(self, name) for name in names}
        about = {name: getattr(self.score, name) for name in ("name", "title", "unit", "better")}
        numbers = {name: _finite(value) for name, value in vars(self.interval).items()}
        return {**facts, "score": about, **numbers}


def _finite(value: float) -> float | None:
    """Return a number, or None where JSON has none for it."""
    return value if np.isfinite(value) else None


def load_touches(store: Store, sensor_set: SensorSet, encode: Encode | None = None) -> Touches:
    """Return the pictures of a set, the masks of their contacts, and their latent vectors.

    Parameters
    ----------
    store : Store
        The store of the set.
    sensor_set : SensorSet
        The set to read.
    encode : callable, optional
        Gives the latent vectors; without it there are none.
    """
    pictures = load_pictures(store, sensor_set)
    background = background_of(store, sensor_set)
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
    """Yield scores of all pairs of sets, or of all sets against the named ones; two sets are in memory at a time.

    Scores of pictures compare the whole frame, and the contact where both sensors have a picture without contact.
    Scores of latent vectors compare each kind of vector.

    Parameters
    ----------
    store : Store
        The store of the sets.
    scores : list of (metric, Score)
        Scores with the names of their metrics.
    sets : list of SensorSet
        Sets to compare.
    against : list of str, optional
        Names of the sets that all others are scored against; each pair once where it is None.
    encode : callable, optional
        Gives latent vectors; without it scores of latent vectors have nothing to compare.
    progress : callable, optional
        Called with pairs done, pairs in all, and the names of the pair.
    """
    pairs = list(_pairs(sets, against))
    loaded: dict[str, Touches] = {}
    for done, (first, second) in enumerate(pairs, start=1):
        # the two sets of this pair stay in memory, others go
        for gone in set(loaded) - {first.name, second.name}:
            del loaded[gone]
        for sensor_set in (first, second):
            if sensor_set.name not in loaded:
                loaded[sensor_set.name] = load_touches(store, sensor_set, encode)
        for metric, score in scores:
            for looked_at, values in _values(metric, score, loaded[first.name], loaded[second.name]):
                interval = bootstrap(values, first.trajectories)
                kinds = first.kind, second.kind
                yield PairScore(metric, score, first.name, second.name, *kinds, looked_at, interval)
        if progress is not None:
            progress(done, len(pairs), f"{first.name} and {second.name}")


def _pairs(sets: Sequence[SensorSet], against: Sequence[str] | None) -> Iterator[tuple[SensorSet, SensorSet]]:
    """Yield all pairs of sets once, or each set with each other one that is named."""
    for index, first in enumerate(sets):
        for second in sets if against is not None else sets[index + 1 :]:
            if second is not first and (against is None or second.name in against):
                yield first, second


def _values(metric: str, score: Score, ours: Touches, theirs: Touches) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Yield what was compared, and the values (n,) of a score for the first set."""
    if METRICS[metric].takes == "latent sets":
        for name in ours.vectors:
            if name in theirs.vectors:
                yield name, score.compute(ours.vectors[name], theirs.vectors[name])
        return
    yield "frame", score.compute(ours.pictures, theirs.pictures)
    if ours.masks is not None and theirs.masks is not None and ours.masks.any() and theirs.masks.any():
        yield "contact", score.compute(ours.pictures, theirs.pictures, ours.masks, theirs.masks)
