"""One picture of an untouched sensor from several frames, and the checks of these frames."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactiledata.arrays import PictureArray
from tactiledata.errors import UsageError
from tactiledata.sensors.image_checks import channel_order, shows_contact


def average_background(frames: Sequence[PictureArray], names: Sequence[str]) -> PictureArray:
    """Return the mean (H, W, 3), uint8, of n frames of an untouched sensor, whose noise is that of one frame over √n.

    Each of three and more frames is compared with the median of all, two are compared with each other. A touch shows
    there, unless it is in most of the frames. One picture alone cannot be checked: see decision 0015.

    Parameters
    ----------
    frames : list of (H, W, 3) uint8 RGB
        At least one frame, all of one sensor in one place.
    names : list of str
        Name of each frame, for messages.

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
    """Refuse frames of which one differs from the median of all, or one of two from the other, as by a touch."""
    middle = np.rint(np.median(frames, axis=0)).astype(np.uint8) if len(frames) > 2 else frames[0]
    touched = [name for frame, name in zip(frames, names, strict=True) if shows_contact(frame, middle).is_contact]
    if not touched:
        return
    if len(frames) == 2:
        problem = f"{names[0]} and {names[1]} differ from each other as a touch makes them differ"
    else:
        problem = f"{', '.join(touched)} {'shows' if len(touched) == 1 else 'show'} a touch"
    raise UsageError(
        problem,
        "frames of the untouched sensor",
        "Leave touched frames out; if the sensor was moved or its light changed in between, take the frames anew.",
        touched=touched,
    )


def refuse_swapped_channels(image: PictureArray, name: str, reference: PictureArray | None = None) -> None:
    """Refuse a picture of a DIGIT whose channels are clearly BGR instead of RGB.

    Parameters
    ----------
    image : (H, W, 3) uint8
        A picture of a DIGIT, upright.
    name : str
        Name of the picture, for the message.
    reference : (H, W, 3) uint8 RGB, optional
        A picture of the same unit that is known to be RGB; by default the mean of the bundled units.

    Raises
    ------
    UsageError
        Red and blue are swapped.
    """
    order = channel_order(image, reference)
    if order.verdict == "bgr":
        raise UsageError(
            f"red and blue of {name} are swapped: correlation {order.score:.2f} with "
            + ("pictures of real DIGIT sensors" if reference is None else "this sensor's own picture"),
            "an RGB picture",
            "Swap its channels (OpenCV and digit-interface give BGR), or give --unchecked if it is right as it is.",
        )


def _size(image: PictureArray) -> str:
    """Return the size of a picture in words."""
    return f"{image.shape[0]} rows x {image.shape[1]} columns"
