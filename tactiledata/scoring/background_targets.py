"""Scores against a sensor of which only the picture without contact is known: they compare pixels outside contacts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import PictureArray
from tactiledata.errors import StoreError, UsageError
from tactiledata.metrics import METRICS
from tactiledata.metrics.base import Score
from tactiledata.metrics.bootstrap import bootstrap
from tactiledata.scoring.sensor_pairs import PairScore
from tactiledata.scoring.sensor_sets import SensorSet, background_of, contact_masks, load_pictures
from tactiledata.sensors.image_checks import CONTACT_BLUR
from tactiledata.store.read.reader import Store
from tactiledata.store.read.targets import Target

KIND = "picture without contact"
"""Kind of the pictures of such a target, in tables."""
OUTSIDE = "outside the contact"
"""Part of the pictures that is compared, in tables."""
FRINGE = 3.0
"""Widths of the blur of `shows_contact` by which a contact is widened: the blur does not reach further."""


def score_backgrounds(
    store: Store, scores: Sequence[tuple[str, Score]], sets: Sequence[SensorSet], targets: Sequence[Target]
) -> Iterator[PairScore]:
    """Yield scores of the pictures of sets, outside their contacts, against the pictures without contact of targets.

    One set is in memory at a time. Sets whose sensor has no picture without contact have no scores, because the place
    of their contacts is not known (`unlocated` names them).

    Parameters
    ----------
    store : Store
        The store of the sets.
    scores : list of (metric, Score)
        Scores with the names of their metrics; those of latent vectors need touches and are left out.
    sets : list of SensorSet
        Sets to score.
    targets : list of Target
        Sensors to score against.

    Raises
    ------
    UsageError
        No score is one of pictures.
    StoreError
        The place of the contact is known in no set, or the contact fills every picture of a set.
    """
    # scores and sets that can be compared
    of_pictures = [(metric, score) for metric, score in scores if METRICS[metric].takes == "image sets"]
    names = ", ".join(target.name for target in targets)
    if not of_pictures:
        raise UsageError(
            f"{', '.join(score.name for _, score in scores)} against {names}, of which no touch is known",
            "a score of pictures, such as histogram_intersection or gram_style",
            "Latent vectors are of touches: they need touches of the target.",
        )
    missing = unlocated(store, sets)
    if len(missing) == len(sets):
        raise StoreError(
            f"no sensor of {store.location} has a picture without contact of its frames' size",
            f"one of each sensor that is scored against {names}: it tells where the contact is",
            f"`tactiledata sensors add {sets[0].sensor} --background FILE...` adds one.",
        )
    # set by set, outside its contacts
    for located in (sensor_set for sensor_set in sets if sensor_set.name not in missing):
        pictures = load_pictures(store, located)
        outside = outside_contact(contact_masks(pictures, background_of(store, located)))
        if not outside.any():
            raise StoreError(
                f"all of every picture of {located.name} differs from the picture of {located.sensor} without contact",
                "pictures with something outside the contact",
                f"If that picture is of another sensor: `tactiledata sensors add {located.sensor} --background FILE... "
                "--replace`.",
            )
        for target in targets:
            for metric, score in of_pictures:
                values = _values(score, pictures, target.background, outside)
                interval = bootstrap(values, located.trajectories)
                yield PairScore(metric, score, located.name, target.name, located.kind, KIND, OUTSIDE, interval)


def _values(
    score: Score, pictures: PictureArray, background: PictureArray, outside: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Scores (n,) of pictures against a background, each under its own mask where the sizes are equal.

    Under the masks of other pictures, other places of the background would be compared: what is brighter there would
    count as another look. A picture whose mask is empty is NaN.
    """
    if background.shape[:2] != outside.shape[1:]:
        return score.compute(pictures, background[None], outside, np.ones((1, *background.shape[:2]), bool))
    values = np.full(len(pictures), np.nan)
    for row in np.flatnonzero(outside.any(axis=(1, 2))):
        mask = outside[row : row + 1]
        values[row] = score.compute(pictures[row : row + 1], background[None], mask, mask)[0]
    return values


def unlocated(store: Store, sets: Sequence[SensorSet]) -> list[str]:
    """Return the names of the sets whose sensor has no picture without contact of the size of their pictures."""
    lacking = []
    for sensor_set in sets:
        background = background_of(store, sensor_set)
        first = np.asarray(store.images(sensor_set.rows[:1])[0])
        if background is None or background.shape != first.shape:
            lacking.append(sensor_set.name)
    return lacking


def outside_contact(masks: NDArray[np.bool_] | None) -> NDArray[np.bool_]:
    """Return masks (n, H, W) of the pixels that show nothing of the touch: all but the widened contacts."""
    assert masks is not None  # sets without masks are left out
    reach = int(np.ceil(FRINGE * CONTACT_BLUR * max(masks.shape[1:])))
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    return np.stack([cv2.dilate(mask.astype(np.uint8), disc) == 0 for mask in masks])


def sentences(targets: Sequence[Target], missing: Sequence[str]) -> list[str]:
    """Return sentences on what scores against such targets can and cannot show, and on sets without scores."""
    lines = []
    for target in targets:
        lines += [
            f"{target.name} is known by its picture without contact alone: {target.resolved}.",
            "Scores against it compare light and colours outside the contact. A method that lays its change on this "
            "picture agrees with it there by construction.",
            f"Whether a touch looks as it would on {target.name} cannot be said: that needs recorded touches of it.",
        ]
    if missing:
        lines.append(
            f"Not scored: {', '.join(missing)}. Without a picture of that sensor without contact it is not known where "
            "the contact is."
        )
    return lines
