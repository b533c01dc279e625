"""Transferred pictures against the target's own pictures of the same touches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from split_models.learning.contact_region import contact_region
from split_models.tables.evaluate import MASKED, Values
from tactiledata.arrays import PictureArray
from tactiledata.metrics.base import Score
from tactiledata.metrics.image_similarity import IMAGE_SIMILARITY

Masks = NDArray[np.bool_]


def overlap(ours: Masks, theirs: Masks) -> NDArray[np.float64]:
    """Intersection over union (n,) of masks (n, H, W); NaN where the second one is empty."""
    either = (ours | theirs).sum(axis=(1, 2))
    share = (ours & theirs).sum(axis=(1, 2)) / np.maximum(either, 1)
    return np.where(theirs.any(axis=(1, 2)), share, np.nan)


PAIRED_SCORES = {
    **{name: IMAGE_SIMILARITY.scores[name] for name in ("ssim", "l1")},
    "overlap": Score("overlap", "overlap of the contact (IoU)", "", "higher", 1.0, overlap),
    "overlap_of_change": Score("overlap_of_change", "overlap of the change (IoU)", "", "higher", 1.0, overlap),
}
"""By name; a style distance is added where one is asked for."""


def paired_values(
    pictures: PictureArray,
    truth: PictureArray,
    background: PictureArray,
    untouched: PictureArray,
    style: Score | None = None,
) -> Values:
    """Scores (n,) of transferred pictures beside the true ones.

    Of the full frame, and under ``<name>_contact`` inside the region in which the true picture shows the touch.
    ``overlap`` is that of the true region with the one in which the transferred picture differs from the target's
    background, as whoever receives it would look for the touch; ``overlap_of_change`` with the one in which it
    differs from what the method makes of no touch, which forgives a wrong background.

    Parameters
    ----------
    pictures, truth : (n, H, W, 3) uint8
        For a style distance, of one touch: each picture is held against the mean of all true ones.
    background : (H, W, 3) uint8
        The target without contact.
    untouched : (H, W, 3) uint8
        What the method makes of the source without contact.
    style : Score, optional
        Inside the contact.
    """
    region = contact_region(truth, background)
    found: Values = {}
    for name in ("ssim", "l1"):
        score = PAIRED_SCORES[name]
        found[name] = score(pictures, truth)
        found[f"{name}{MASKED}"] = score(pictures, truth, region)
    if style is not None:
        there = region.any()
        values = style.compute(pictures, truth, region, region) if there else np.full(len(truth), np.nan)
        found[f"{style.name}{MASKED}"] = values
    found["overlap"] = overlap(contact_region(pictures, background), region)
    found["overlap_of_change"] = overlap(contact_region(pictures, untouched), region)
    return found
