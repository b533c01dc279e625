"""One picture of an untouched sensor from several frames, and what speaks against it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactiledata.arrays import PictureArray
from tactiledata.errors import UsageError
from tactiledata.sensors.image_checks import channel_order, shows_contact


def average_background(frames: Sequence[PictureArray], names: Sequence[str]) -> PictureArray:
    """The mean of frames of an untouched sensor (H, W, 3), rounded: its noise is that of one frame over √n.

    Each of three and more frames is held against the median of all, two against each other. A touch stands out there,
    unless it is in most of the frames. One picture alone cannot be judged: see decision 0015.

    Parameters
    ----------
    frames : list of (H, W, 3) uint8 RGB
        At least one, of one sensor in one place.
    names : list of str
        Of the frames, for messages.

    Raises
    ------
    UsageError
        No frame, sizes that differ, or a frame that shows a touch.
    """
    if not frames:
        raise UsageError("no picture of the untouched sensor", "one or more", "Name them after --background.")
    for frame, name in zip(frames, names, strict=True):
        if frame.shape != frames[0].shape:
            raise UsageError(
                f"{name} has {_size(frame)} and {names[0]} has {_size(frames[0])}",
                "frames of one size",
                "Average frames of one camera setting only.",
            )
    _refuse_touched(frames, names)
    return np.rint(np.mean(frames, axis=0, dtype=np.float64)).astype(np.uint8)


def _refuse_touched(frames: Sequence[PictureArray], names: Sequence[str]) -> None:
    middle = np.rint(np.median(frames, axis=0)).astype(np.uint8) if len(frames) > 2 else frames[0]
    touched = [name for frame, name in zip(frames, names, strict=True) if shows_contact(frame, middle).is_contact]
    if not touched:
        return
    if len(frames) == 2:
        found = f"{names[0]} and {names[1]} differ from each other as a touch makes them differ"
    else:
        found = f"{', '.join(touched)} {'shows' if len(touched) == 1 else 'show'} a touch"
    raise UsageError(
        found,
        "frames of the untouched sensor",
        "Leave touched frames out; if the sensor was moved or its light changed in between, take the frames anew.",
        touched=touched,
    )


def refuse_swapped_channels(image: PictureArray, name: str, reference: PictureArray | None = None) -> None:
    """Nothing, where a DIGIT's picture is not clearly BGR.

    Parameters
    ----------
    image : (H, W, 3) uint8
        Of a DIGIT, upright.
    name : str
        For the message.
    reference : (H, W, 3) uint8 RGB, optional
        The same unit, known to be RGB; the mean of the bundled units otherwise.

    Raises
    ------
    UsageError
        Red and blue are swapped.
    """
    found = channel_order(image, reference)
    if found.verdict == "bgr":
        raise UsageError(
            f"red and blue of {name} are swapped: correlation {found.score:.2f} with "
            + ("pictures of real DIGIT sensors" if reference is None else "this sensor's own picture"),
            "an RGB picture",
            "Swap its channels (OpenCV and digit-interface give BGR), or say --unchecked if it is right as it is.",
        )


def _size(image: PictureArray) -> str:
    return f"{image.shape[0]} rows x {image.shape[1]} columns"
