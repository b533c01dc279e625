"""Backgrounds (pictures without contact) of the sensors that an image VAE was trained on, kept in its checkpoint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
import torch
from torch import Tensor

from tactiledata.arrays import PictureArray

Learned = tuple[tuple[str, PictureArray], ...]
"""Names of sensors with their pictures without contact; empty where the training sensors are not known."""
PREFIX = "background/"
"""Beginning of a background's key among the extras of a checkpoint."""
LONG, SHORT = 40, 30
"""Sides of a kept picture in px: enough to distinguish sensors (`tactiledata.sensors.same_sensor`)."""


def kept_small(pictures: Sequence[tuple[str, PictureArray]]) -> Learned:
    """The named pictures (h, w, 3), each scaled to 40 x 30 px, or to 30 x 40 px where it is wider than high."""
    return tuple((name, _small(picture)) for name, picture in pictures)


def as_extras(trained: Learned) -> dict[str, Tensor]:
    """The named pictures as extras of a checkpoint; keys hold the number and the name."""
    return {
        f"{PREFIX}{number}/{name}": torch.from_numpy(np.ascontiguousarray(picture))
        for number, (name, picture) in enumerate(trained)
    }


def of_extras(extras: Mapping[str, Tensor]) -> Learned:
    """The named pictures from the extras of a checkpoint, in the order in which they were saved."""
    keys = sorted((key for key in extras if key.startswith(PREFIX)), key=lambda key: int(key.split("/", 2)[1]))
    return tuple((key.split("/", 2)[2], extras[key].numpy()) for key in keys)


def _small(picture: PictureArray) -> PictureArray:
    """The picture (h, w, 3), scaled by area to 40 x 30 px or 30 x 40 px."""
    size = (SHORT, LONG) if picture.shape[0] >= picture.shape[1] else (LONG, SHORT)
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
