"""A recording's images beside its pictures without contact: swapped channels, and pictures that show a touch."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import PictureArray
from tactiledata.contract.records import Finding
from tactiledata.contract.take import UNUSABLE, Take
from tactiledata.sensors import SENSORS
from tactiledata.sensors.image_checks import channel_order, is_one_colour, shows_contact, size_orientation
from tactiledata.store.read.free_air import FREE_AIR, LEAST_FRAMES

MOST_FRAMES = 8
"""Frames in free air that a picture without contact is compared with."""

Decode = Callable[[NDArray[np.int64]], list[NDArray[np.uint8] | None]]


def stated_background(take: Take, sensor: str) -> PictureArray | None:
    """The picture without contact that a recording brings; ``None`` for none, or a mean of its own images."""
    reference = take.references.get(sensor)
    return None if reference is None or reference.origin.startswith("mean of") else reference.image


def channel_findings(sensor: str, images: Sequence[PictureArray], take: Take, model: str) -> list[Finding]:
    """BGR taken for RGB, in the images, in the picture without contact, or in both.

    Images are held against the sensor's own picture, whatever its model. Only pictures of DIGITs have known
    colours: they tell which of the two is swapped, and whether both are.

    Parameters
    ----------
    sensor : str
    images : list of (H, W, 3) uint8 RGB
        Some of the sensor's images.
    take : Take
        Its reference of the sensor is the picture without contact.
    model : str
        The sensor's model.
    """
    background = stated_background(take, sensor)
    if background is None and model != "digit":
        return []
    against_own = [channel_order(image, background).verdict for image in images if _alike(image, background)]
    is_swapped = against_own.count("bgr") > len(against_own) / 2
    known = "unsure"
    if background is not None and model == "digit" and size_orientation(background.shape[:2], SENSORS[model]) == "ok":
        known = channel_order(background).verdict
    if background is None:
        what, against = f"images of {sensor!r}", "known DIGIT sensors"
    elif is_swapped and known == "bgr":
        what, against = f"the picture without contact of {sensor!r}", "its images and known DIGIT sensors"
    elif is_swapped:
        what, against = f"images of {sensor!r}", "the sensor's background"
    elif known == "bgr" and against_own.count("rgb") > len(against_own) / 2:
        what, against = f"images of {sensor!r} and its picture without contact", "known DIGIT sensors"
        is_swapped = True
    if not is_swapped:
        return []
    text = (
        f"{what} look like BGR against {against}: blue and red are swapped. State channel_order in a mapping, or save "
        "the pictures with their channels in order (OpenCV writes BGR arrays right), and ingest with --replace"
    )
    return [Finding("channels-swapped", "warning", text)]


def touched_findings(sensor: str, take: Take, decode: Decode) -> list[Finding]:
    """A warning where a recording's own picture without contact is of one colour, or shows what looks like a touch.

    A touch shows where it differs from the recording's own frames in free air. Only forces tell which frames those are:
    without forces, or with fewer than three such frames, nothing is said of a touch.

    Parameters
    ----------
    sensor : str
    take : Take
    decode : callable
        Images of rows of ``take.frames``.
    """
    background = stated_background(take, sensor)
    if background is None:
        return []
    if is_one_colour(background):
        text = (
            f"the picture without contact of {sensor!r} is of one colour throughout, as no picture of a gel is: "
            "whatever is compared with it would look touched everywhere. Take it again with the light on"
        )
        return [Finding("background-blank", "warning", text)]
    names = np.array(take.frames["sensor"].to_pylist(), dtype=object)
    free = (take.frames["contact_force"].to_numpy() < FREE_AIR) & ((take.frames["flags"].to_numpy() & UNUSABLE) == 0)
    rows = np.flatnonzero((names == sensor) & free)
    if len(rows) < LEAST_FRAMES:
        return []
    chosen = rows[np.unique(np.linspace(0, len(rows) - 1, MOST_FRAMES).astype(int))]
    seen = [image for image in decode(chosen) if image is not None and image.shape == background.shape]
    if len(seen) < LEAST_FRAMES:
        return []
    contact = shows_contact(np.rint(np.median(seen, axis=0)).astype(np.uint8), background)
    if not contact.is_contact:
        return []
    text = (
        f"the picture without contact of {sensor!r} differs from {len(seen)} of its frames in free air as a touch "
        f"makes it differ ({contact.score:.0f} grey levels and more over part of it): it shows a touch, or the light, "
        "the camera or the gel was changed since. Take it again with nothing touching"
    )
    return [Finding("background-touched", "warning", text)]


def _alike(image: PictureArray, background: PictureArray | None) -> bool:
    return background is None or image.shape == background.shape
