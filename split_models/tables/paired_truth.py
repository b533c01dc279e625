"""Scores of transferred pictures against the target's own pictures of the same touches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from split_models.learning.contact_region import contact_region
from split_models.tables.evaluate import MASKED, Values
from tactiledata.arrays import PictureArray
from tactiledata.metrics.base import Score
from tactiledata.metrics.image_similarity import IMAGE_SIMILARITY
from tactiledata.metrics.kept_touch import KEPT_TOUCH, change_of

Masks = NDArray[np.bool_]


def overlap(ours: Masks, theirs: Masks) -> NDArray[np.float64]:
    """Intersection over union (n,) of masks (n, H, W); NaN where the mask in ``theirs`` is empty."""
    either = (ours | theirs).sum(axis=(1, 2))
    share = (ours & theirs).sum(axis=(1, 2)) / np.maximum(either, 1)
    return np.where(theirs.any(axis=(1, 2)), share, np.nan)


KEPT_SCORES = KEPT_TOUCH.scores
"""Scores of how much of the recorded touch is kept, by name."""
PAIRED_SCORES = {
    **{name: IMAGE_SIMILARITY.scores[name] for name in ("ssim", "l1")},
    "overlap": Score("overlap", "overlap of the contact (IoU)", "", "higher", 1.0, overlap),
    "overlap_of_change": Score("overlap_of_change", "overlap of the change (IoU)", "", "higher", 1.0, overlap),
    **KEPT_SCORES,
}
"""Scores of paired pictures by name; callers may add a style distance."""


def paired_values(
    pictures: PictureArray,
    truth: PictureArray,
    background: PictureArray,
    untouched: PictureArray,
    style: Score | None = None,
) -> Values:
    """Scores (n,) of transferred pictures against the true ones, by name.

    ``ssim`` and ``l1`` are of the full frame, and under ``<name>_contact`` of the region in which the true picture
    shows the touch. ``overlap`` compares that region with the one in which the transferred picture differs from the
    target's background, where a user would look for the touch. ``overlap_of_change`` compares it with the region in
    which the transferred picture differs from the transfer of no touch, and so tolerates a wrong background.

    Parameters
    ----------
    pictures, truth : (n, H, W, 3) uint8
        Transferred and true pictures. For a style distance all of one touch: each picture is compared with the mean of
        all true ones.
    background : (H, W, 3) uint8
        The target's picture without contact.
    untouched : (H, W, 3) uint8
        The method's transfer of the source's picture without contact.
    style : Score, optional
        Style distance, inside the contact.
    """
    region = contact_region(truth, background)
    values_of: Values = {}
    for name in ("ssim", "l1"):
        score = PAIRED_SCORES[name]
        values_of[name] = score(pictures, truth)
        values_of[f"{name}{MASKED}"] = score(pictures, truth, region)
    if style is not None:
        there = region.any()
        values = style.compute(pictures, truth, region, region) if there else np.full(len(truth), np.nan)
        values_of[f"{style.name}{MASKED}"] = values
    values_of["overlap"] = overlap(contact_region(pictures, background), region)
    values_of["overlap_of_change"] = overlap(contact_region(pictures, untouched), region)
    return values_of


def kept_values(
    pictures: PictureArray, background: PictureArray, recorded: PictureArray, recorded_background: PictureArray
) -> Values:
    """Scores (n,) of how much of recorded touches transferred pictures keep, by name.

    Parameters
    ----------
    pictures, recorded : (n, H, W, 3) uint8
        Transferred pictures, and those that they were made of.
    background, recorded_background : (H, W, 3) uint8
        Target and source without contact.
    """
    ours, theirs = change_of(pictures, background), change_of(recorded, recorded_background)
    return {name: score(ours, theirs) for name, score in KEPT_SCORES.items()}
