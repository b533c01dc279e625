"""Which of two folders holds tactile images and which holds photographs, by statistics of their pictures.

A DIGIT's picture is 320 x 240, lit from three sides in three colours (its hue changes smoothly from edge to edge),
without fine detail, and much the same from image to image. A photograph has other sizes, hardly any such colour field,
fine detail, and changes as the camera moves. No single sign is safe; four of them vote.

Shared by the family, as `base` is: members may import it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

DIGIT_SIDES = (240, 320)
"""Pixels."""
THUMBNAIL = 8
DECISION = 1.5
"""Votes, of at most 4, beyond which the folders are told apart; below, no judgement is passed."""


@dataclass(frozen=True)
class Look:
    """What a folder's pictures look like.

    Parameters
    ----------
    digit_sized : float
        Share of pictures with a DIGIT's sides.
    colour_field : float
        How much the colour (brightness taken out) changes over a thumbnail, relative to brightness.
    detail : float
        Energy of the finest structures relative to all structure.
    change : float
        How much thumbnails differ from picture to picture, relative to brightness.
    """

    digit_sized: float
    colour_field: float
    detail: float
    change: float


def look_of(pictures: Sequence[NDArray[np.uint8]]) -> Look:
    """The statistics of pictures (H, W, 3), RGB; at least one."""
    import cv2

    sized = [tuple(sorted(picture.shape[:2])) == DIGIT_SIDES for picture in pictures]
    small = [cv2.resize(picture, (THUMBNAIL, THUMBNAIL), interpolation=cv2.INTER_AREA) for picture in pictures]
    thumbnails = np.stack(small).astype(np.float64)
    brightness = thumbnails.mean() + 1.0
    chroma = thumbnails - thumbnails.mean(axis=3, keepdims=True)
    field = np.sqrt(((chroma - chroma.mean(axis=(1, 2), keepdims=True)) ** 2).sum(axis=3).mean())
    change = np.sqrt(((thumbnails - thumbnails.mean(axis=0)) ** 2).mean()) if len(pictures) > 1 else 0.0
    return Look(float(np.mean(sized)), float(field / brightness), _detail(pictures), float(change / brightness))


def _detail(pictures: Sequence[NDArray[np.uint8]]) -> float:
    import cv2

    shares = []
    for picture in pictures:
        grey = cv2.cvtColor(cv2.resize(picture, (160, 120), interpolation=cv2.INTER_AREA), cv2.COLOR_RGB2GRAY)
        fine = grey - cv2.GaussianBlur(grey.astype(np.float32), (0, 0), 1.5)
        shares.append(float(fine.std() / (grey.std() + 1.0)))
    return float(np.mean(shares))


def votes_tactile(one: Look, other: Look) -> float:
    """Votes, from -4 to 4, for the first folder being the tactile one of the two."""
    return float(
        (one.digit_sized - other.digit_sized)
        + np.tanh(2 * np.log((one.colour_field + 0.01) / (other.colour_field + 0.01)))
        + np.tanh(2 * np.log((other.detail + 0.01) / (one.detail + 0.01)))
        + np.tanh(2 * np.log((other.change + 0.01) / (one.change + 0.01)))
    )
