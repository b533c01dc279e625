"""Checks of a picture: is it turned, are its channels swapped, does it show a touch?"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import PictureArray
from tactiledata.errors import UsageError
from tactiledata.sensors.backgrounds import bundled_backgrounds, load_background
from tactiledata.sensors.base import Sensor

LAYOUT_CELLS = (8, 6)
"""Rows and columns of the coarse map of colours: 4 x 3 separates all units but one, and 16 x 12 does no better."""
LAYOUT_CERTAIN = 0.25
"""Correlation from which on the order of channels is decided; ``channel_order`` says how often that is wrong."""
LAYOUT_COLOURLESS = 4.0
"""Root mean square of red minus blue over the cells, grey levels, below which a picture has no colours to compare: the
palest bundled picture has 17, pure noise over all levels 2.6."""
CONTACT_LEVELS = 15.0
"""Change, grey levels, that counts as touched: twice that of a shift by one pixel; see ``shows_contact``."""
CONTACT_AREA = 0.005
"""Share of the picture that must change: on a DIGIT about 1.5 mm2."""
CONTACT_BLUR = 1 / 100
"""Width of the blur over the longer side of the picture: it removes camera noise and JPEG blocks, and keeps a contact
of 1 mm."""
ONE_COLOUR = 3.0
"""Grey levels: standard deviation of every channel below which a picture counts as of one colour. A covered or unlit
camera's noise is 1 to 2; the bundled pictures of gels have 10 and more."""


def is_one_colour(picture: PictureArray) -> bool:
    """Whether a picture (H, W, 3) has one colour throughout, but for the noise of a camera."""
    return bool(picture.reshape(-1, 3).std(axis=0).max() < ONE_COLOUR)


def orientation_of(image: PictureArray, sensor: Sensor) -> Literal["ok", "swapped", "other size"]:
    """Return whether a picture has rows and columns of the sensor, the two swapped, or another size.

    Examples
    --------
    >>> from tactiledata.sensors import SENSORS
    >>> orientation_of(np.zeros((240, 320, 3), np.uint8), SENSORS["digit"])
    'swapped'
    """
    return size_orientation(image.shape[:2], sensor)


def size_orientation(shape: tuple[int, ...], sensor: Sensor) -> Literal["ok", "swapped", "other size"]:
    """Return whether rows and columns are those of the sensor, the two swapped, or others; refuse a force sensor."""
    if sensor.camera is None:
        raise UsageError(f"sensor {sensor.name!r} takes no pictures", "a tactile sensor")
    if shape == sensor.camera.shape:
        return "ok"
    return "swapped" if shape == sensor.camera.shape[::-1] else "other size"


@dataclass(frozen=True)
class ChannelOrder:
    """The order of channels that a picture seems to have, and the correlation, -1 to 1, on which that rests."""

    verdict: Literal["rgb", "bgr", "unsure"]
    score: float


def channel_order(image: PictureArray, reference: PictureArray | None = None) -> ChannelOrder:
    """Return whether a picture is RGB, as it should be, or BGR, or whether that cannot be decided.

    The coarse map of red minus blue changes its sign when the channels are swapped. It is correlated with the map of
    a picture of the same sensor, or without one with the mean map of the bundled DIGIT pictures: red LED on one side,
    blue towards one end.

    Measured, leaving each of the 18 bundled pictures out of the mean in turn: 17 right, none wrong, 1 unsure (a unit
    with a blue spot where others are red), as RGB and swapped alike; two real pictures of contacts by others: right.
    Without a reference it holds for upright DIGIT pictures only, not for turned ones or for another sensor.

    Parameters
    ----------
    image : (rows, columns, 3), uint8
        The picture.
    reference : (rows, columns, 3), uint8 RGB, optional
        A picture of the same unit that is known to be RGB; a contact in either matters little.
    """
    layout = _layout(image)
    expected = _digit_layout() if reference is None else _layout(reference)
    if layout is None or expected is None:
        return ChannelOrder("unsure", 0.0)
    score = float((layout * expected).sum())
    if abs(score) < LAYOUT_CERTAIN:
        return ChannelOrder("unsure", score)
    return ChannelOrder("rgb" if score > 0 else "bgr", score)


def _layout(image: PictureArray) -> NDArray[np.float32] | None:
    """Coarse map of red minus blue, ``LAYOUT_CELLS``, mean 0 and norm 1; ``None`` for a picture without colours."""
    if image.ndim != 3 or image.shape[2] != 3:
        return None
    cells = cv2.resize(image.astype(np.float32), LAYOUT_CELLS[::-1], interpolation=cv2.INTER_AREA)
    difference = np.asarray(cells[..., 0] - cells[..., 2])
    difference = difference - difference.mean()  # a tint of the whole picture does not depend on the order
    norm = float(np.linalg.norm(difference))
    return None if norm < LAYOUT_COLOURLESS * np.sqrt(difference.size) else difference / norm


def mean_layout(images: list[PictureArray]) -> NDArray[np.float32]:
    """Mean map of red minus blue, ``LAYOUT_CELLS``, norm 1, of pictures that are known to be RGB."""
    mean = np.mean([layout for image in images if (layout := _layout(image)) is not None], axis=0)
    return mean / np.linalg.norm(mean)


@cache
def _digit_layout() -> NDArray[np.float32]:
    """Mean map of red minus blue of the bundled pictures, read-only."""
    layout = mean_layout([load_background(name) for name in bundled_backgrounds()])
    layout.flags.writeable = False
    return layout


@dataclass(frozen=True)
class Contact:
    """Whether a picture shows a touch, by how much it changed, and where.

    Parameters
    ----------
    is_contact : bool
        Whether the picture shows a touch.
    score : float
        Change, grey levels, that ``CONTACT_AREA`` of the picture exceeds.
    mask : (rows, columns), bool
        Where the change is at least ``CONTACT_LEVELS``.
    """

    is_contact: bool
    score: float
    mask: NDArray[np.bool_]


def shows_contact(image: PictureArray, background: PictureArray) -> Contact:
    """Return whether a picture differs from the untouched picture of its sensor as by a touch, and where.

    Per channel the brightness is matched by the medians (LEDs warm up, exposure moves), the difference is blurred, and
    the picture counts as touched where ``CONTACT_AREA`` of it changes by ``CONTACT_LEVELS`` or more.

    Measured: all 49 presses of the ObjectFolder GelSight change by 97 levels or more. A real DIGIT contact changes by
    106 against a background filled in from its surroundings, and its mask covers 81 % of its union with the mask drawn
    by its authors. Laid on the 18 bundled pictures at a quarter of its strength that contact gives 25 and is seen, at a
    tenth 10 and is not. Untouched bundled pictures: noise of 7 levels with JPEG quality 50 gives at most 6, gains of
    0.9 to 1.05 at most 9, one pixel of shift at most 8, two pixels 15. So a camera that moved by two pixels, and a unit
    whose bright spot saturates when the gain rises by a tenth (19), are taken for a touch.

    Parameters
    ----------
    image : (rows, columns, 3), uint8 RGB
        The picture.
    background : (rows, columns, 3), uint8 RGB
        The same sensor without contact.

    Raises
    ------
    UsageError
        The two pictures differ in shape.
    """
    if image.shape != background.shape or image.ndim != 3:
        raise UsageError(
            f"a picture of shape {image.shape} cannot be compared with a background of shape {background.shape}",
            "two pictures (rows, columns, 3) of one sensor",
        )
    seen, untouched = image.astype(np.float32), background.astype(np.float32)
    level = np.maximum(np.median(untouched, axis=(0, 1)), 1.0)
    difference = seen - untouched * (np.median(seen, axis=(0, 1)) / level)
    blurred = cv2.GaussianBlur(difference, (0, 0), CONTACT_BLUR * max(image.shape))
    change = np.linalg.norm(blurred, axis=2)
    score = float(np.quantile(change, 1.0 - CONTACT_AREA))
    return Contact(score >= CONTACT_LEVELS, score, change >= CONTACT_LEVELS)
