"""Real pictures of untouched DIGIT sensors that travel with the package, under names."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from importlib.resources.abc import Traversable

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UnknownName

SOURCE = "https://github.com/suddhu/tacto (tacto/bgs)"
LICENCE = "MIT"
ATTRIBUTION = (
    "Copyright (c) Facebook, Inc. and its affiliates; tacto, fork by Sudharshan Suresh (YCB-Slide, MidasTouch)"
)

FILE_NUMBERS = (0, 4, 5, 6, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21)
"""Numbers of the pictures as their source names them (``bg_<number>.jpg``); names here count from 0 without gaps."""

ALIASES = {"ycb-sensorA": "digit-bg-0", "ycb-sensorB": "digit-bg-1"}
"""Two sensors by the authors of YCB-Slide. Which two units the SPLIT paper calls sensor A and sensor B it does not say:
these are our choice among the pictures that those authors published."""


@dataclass(frozen=True)
class BackgroundInfo:
    """A picture of a sensor that nothing touches, and where it comes from."""

    name: str
    path: Traversable
    source: str
    licence: str
    attribution: str


def bundled_backgrounds() -> dict[str, BackgroundInfo]:
    """The 18 bundled pictures by name, ``digit-bg-0`` to ``digit-bg-17``; each another unit or lighting."""
    folder = resources.files("tactiledata.sensors") / "digit_backgrounds"
    return {
        f"digit-bg-{index}": BackgroundInfo(
            f"digit-bg-{index}", folder / f"bg_{number}.jpg", f"{SOURCE}/bg_{number}.jpg", LICENCE, ATTRIBUTION
        )
        for index, number in enumerate(FILE_NUMBERS)
    }


def resolve_background(name: str) -> BackgroundInfo:
    """The bundled picture that a name or an alias stands for.

    Raises
    ------
    UnknownName
        Neither a bundled picture nor an alias.

    Examples
    --------
    >>> resolve_background("ycb-sensorB").source
    'https://github.com/suddhu/tacto (tacto/bgs)/bg_4.jpg'
    """
    bundled = bundled_backgrounds()
    target = ALIASES.get(name, name)
    if target not in bundled:
        raise UnknownName("background", name, [*bundled, *ALIASES])
    return bundled[target]


def load_background(name: str) -> NDArray[np.uint8]:
    """The picture (320, 240, 3), uint8 RGB, of a bundled background or alias."""
    encoded = np.frombuffer(resolve_background(name).path.read_bytes(), np.uint8)
    image = cv2.imdecode(encoded, cv2.IMREAD_COLOR_RGB)
    assert image is not None  # a file of ours
    return np.asarray(image, dtype=np.uint8)
