"""Real pictures of untouched DIGIT sensors that come with the package, by name."""

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
"""Numbers of the pictures in their source (``bg_<number>.jpg``); names here count from 0 without gaps."""

ALIASES = {"ycb-sensorA": "digit-bg-0", "ycb-sensorB": "digit-bg-1"}
"""Names of two sensors of the authors of YCB-Slide. The SPLIT paper does not say which two units it calls sensor A and
sensor B: these are our choice among the pictures that those authors published."""


@dataclass(frozen=True)
class BackgroundInfo:
    """A bundled picture of an untouched sensor, and where it comes from.

    Parameters
    ----------
    name : str
        Name of the picture here.
    path : Traversable
        The file in the package.
    source : str
        Where it was published.
    licence, attribution : str
        Licence, and whom it asks to name.
    """

    name: str
    path: Traversable
    source: str
    licence: str
    attribution: str


def bundled_backgrounds() -> dict[str, BackgroundInfo]:
    """Return the 18 bundled pictures by name, ``digit-bg-0`` to ``digit-bg-17``, each of another unit or lighting."""
    folder = resources.files("tactiledata.sensors") / "digit_backgrounds"
    return {
        f"digit-bg-{index}": BackgroundInfo(
            f"digit-bg-{index}", folder / f"bg_{number}.jpg", f"{SOURCE}/bg_{number}.jpg", LICENCE, ATTRIBUTION
        )
        for index, number in enumerate(FILE_NUMBERS)
    }


def resolve_background(name: str) -> BackgroundInfo:
    """Return the bundled picture that a name or an alias stands for.

    Raises
    ------
    UnknownName
        A name that is neither a bundled picture nor an alias.

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
    """Return the picture (320, 240, 3), uint8 RGB, of a bundled background or alias."""
    encoded = np.frombuffer(resolve_background(name).path.read_bytes(), np.uint8)
    image = cv2.imdecode(encoded, cv2.IMREAD_COLOR_RGB)
    assert image is not None  # the file belongs to the package
    return np.asarray(image, dtype=np.uint8)
