"""Whether one image is a copy of another (compressed again, brighter) or a second picture of the same touch.

A rig that comes back to the same place takes pictures that look alike, and a model may well be tested on one and
trained on the other; what tells a copy is the noise. So one image is turned into what the other would be if it were
its copy: brightness is fitted, and it is compressed as the other was (the quality is recovered from the pixels:
compressing an image again at its own quality changes nothing). What then still differs is measured against what a
second recording's own noise would leave after the same compression. A copy leaves next to nothing, a second recording
about as much as its noise does.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import PictureArray
from tactiledata.splits.fingerprints import LUMA

MARGIN = 16
"""Pixels; crops keep to the grid of compression blocks (8, or 16 with subsampled colour)."""
CROP = (192, 144)
"""Rows and columns, at most, of the middle of an image that is compared."""
JPEG_QUALITY = cv2.IMWRITE_JPEG_QUALITY
QUALITIES = range(50, 97)
"""Qualities that are tried (libjpeg's scale); above, compression takes less than the rounding of colours does."""
IDEMPOTENT = 0.35
"""Grey levels: compressing again at an image's own quality changes it by less than this on average (rounding)."""
TRIFLE = 0.06
"""Grey levels: what is left by rounding alone; below, two images are the same whatever their noise."""
COPY_RATIO = 0.65
"""What is left, over what a second recording's noise would leave: copies measured 0 to 0.55, second recordings 0.88 and
more (docs/splits.md)."""
MOST_LOST = 4.0
"""Grey levels that compression at the lowest quality tried takes from a tactile image, and some more."""
HOPELESS = 2.0
"""A ratio above which fitting brightness more finely cannot help."""
SAME_BRIGHTNESS = 0.3
"""Grey levels, at mid grey: a fitted change below it is none (rounding would have undone it)."""
HELPS = 0.9
"""A finer fit that does not get below this share of what was left is not carried on."""
GRAIN_OF_COLOUR = 1.6
"""Noise of one colour over the fine grain of luma: luma averages three colours (0.67), blurring takes some too."""


@dataclass(frozen=True)
class Comparison:
    """How two images compare.

    Parameters
    ----------
    left : float
        Root-mean-square difference, grey levels, after brightness and compression are accounted for.
    expected : float
        The same for a second recording with the sensor's noise.
    """

    left: float
    expected: float

    @property
    def ratio(self) -> float:
        """What is left over what a second recording would leave; 0 for the same image."""
        return self.left / max(self.expected, 1e-6) if self.left > TRIFLE else 0.0

    @property
    def is_copy(self) -> bool:
        """Whether the two are one recording."""
        return self.ratio <= COPY_RATIO


class Portrait:
    """An image (H, W, 3) uint8 RGB with what comparing it needs, found once."""

    def __init__(self, image: PictureArray) -> None:
        self.shape = image.shape
        self.middle = middle_of(image)

    @cached_property
    def quality(self) -> int:
        """The JPEG quality that it was last compressed at, from its pixels; 0 where it was not."""
        grey = adjusted(self.middle.astype(np.float32) @ LUMA, 1.0, 0.0)
        change = [float(np.abs(compress(grey, quality).astype(np.int16) - grey).mean()) for quality in QUALITIES]
        best = int(np.argmin(change))
        return QUALITIES[best] if change[best] < IDEMPOTENT else 0

    @cached_property
    def smooth(self) -> NDArray[np.float32]:
        """Colours (n,) of the middle without fine grain, at every third pixel."""
        blurred = cv2.GaussianBlur(self.middle.astype(np.float32), (0, 0), 3.0)
        return np.ravel(blurred[::3, ::3]).astype(np.float32)


def noise_between(one: PictureArray, other: PictureArray) -> float:
    """Standard deviation, grey levels, of the noise of each colour, from two recordings by one sensor.

    Their difference has no fixed pattern (markers, dust, pixels). Its fine grain is taken by the median, so that a
    contact that covers less than half of the image does not count.
    """
    if one.shape != other.shape:
        return 0.0
    fine = (one.astype(np.float32) - other) @ LUMA
    fine -= cv2.GaussianBlur(fine, (0, 0), 1.5)
    return float(GRAIN_OF_COLOUR * 1.4826 * np.median(np.abs(fine)) / np.sqrt(2))


def sensor_noise(pictures: Iterable[PictureArray]) -> float:
    """Noise of each colour, grey levels, from pictures of different touches; 0 where there is one only."""
    pairs = [noise_between(one, other) for one, other in pairwise(pictures)]
    return float(np.median(pairs)) if pairs else 0.0


def compare_images(one: Portrait, other: Portrait, noise: float) -> Comparison:
    """How two images compare, whichever of them is the original.

    Parameters
    ----------
    one, other : Portrait
    noise : float
        Standard deviation of each colour, grey levels, from `sensor_noise`.
    """
    if one.shape != other.shape:
        return Comparison(np.inf, noise)
    forth = _compare(one, other, noise)
    if forth.is_copy or not np.isfinite(forth.left):
        return forth
    return min(forth, _compare(other, one, noise), key=lambda found: found.ratio)


def middle_of(image: PictureArray) -> PictureArray:
    """The middle (h, w, 3) of an image, on the grid of compression blocks."""
    top, left = (max(0, (size - most) // 2) // MARGIN * MARGIN for size, most in zip(image.shape, CROP, strict=False))
    # a copy: a view would keep the whole image in memory
    return np.array(image[top : top + CROP[0], left : left + CROP[1]], order="C")


def compress(picture: PictureArray, quality: int) -> PictureArray:
    """A picture, (h, w, 3) or grey (h, w), after JPEG at a quality; as it came where quality is 0."""
    if not quality:
        return picture
    # cv2 takes B, G, R; compressing treats the colours alike only when they are named right
    _, payload = cv2.imencode(".jpg", picture[..., ::-1] if picture.ndim == 3 else picture, [JPEG_QUALITY, quality])
    mode = cv2.IMREAD_COLOR_RGB if picture.ndim == 3 else cv2.IMREAD_GRAYSCALE
    return np.asarray(cv2.imdecode(payload, mode), np.uint8)


def adjusted(picture: NDArray[np.generic], gain: float, offset: float) -> PictureArray:
    """Return a picture with another brightness, ``gain * picture + offset``, rounded as software rounds it.

    Parameters
    ----------
    picture : (rows, columns, 3), grey levels
        The picture.
    gain : float
        Factor on all grey levels.
    offset : float
        Added to them afterwards, grey levels.
    """
    return np.clip(np.rint(picture.astype(np.float32) * gain + offset), 0, 255).astype(np.uint8)


def brightness_fit(original: NDArray[np.float32], other: NDArray[np.float32]) -> tuple[float, float]:
    """Gain and offset (grey levels) with which smooth colours (n,) are most like others, outside saturation."""
    keep = (np.minimum(original, other) > 12) & (np.maximum(original, other) < 243)
    if keep.sum() < 100 or original[keep].std() < 1.0:
        return 1.0, 0.0
    for _ in range(2):
        gain, offset = np.polyfit(original[keep], other[keep], 1)
        off = np.abs(other - (gain * original + offset))
        keep &= off <= 3 * np.median(off[keep]) + 0.01
    return float(gain), float(offset)


def difference(one: PictureArray, other: PictureArray) -> float:
    """Root-mean-square difference of two pictures' luma, grey levels."""
    return float(np.sqrt(np.mean(((one.astype(np.float32) - other) @ LUMA) ** 2)))


def _compare(original: Portrait, other: Portrait, noise: float) -> Comparison:
    start, end = original.middle, other.middle
    fitted = brightness_fit(original.smooth, other.smooth)
    if difference(adjusted(start, *fitted), end) > MOST_LOST + 2 * noise:
        return Comparison(np.inf, noise)
    # a quality may be recovered where there was none: a smooth picture hardly changes at high ones
    trials = [(*light, quality) for light in ((1.0, 0.0), fitted) for quality in {0, other.quality}]
    left, *light, quality = min((_left(original, other, *trial), *trial) for trial in trials)
    # the original holds its own noise once; a second recording differs from it by that of two
    grain = np.random.default_rng(0).normal(0, np.sqrt(2) * noise, start.shape)
    again = compress(adjusted(start + grain, *light), quality)
    expected = difference(again, compress(adjusted(start, *light), quality))
    rough = Comparison(left, expected)
    is_unchanged = abs(fitted[0] - 1) * 128 + abs(fitted[1]) < SAME_BRIGHTNESS
    if rough.is_copy or rough.ratio > HOPELESS or is_unchanged:
        return rough
    return Comparison(_finest(original, other, (left, *light), quality), expected)


def _left(original: Portrait, other: Portrait, gain: float, offset: float, quality: int) -> float:
    return difference(compress(adjusted(original.middle, gain, offset), quality), other.middle)


def _finest(original: Portrait, other: Portrait, start: Sequence[float], quality: int) -> float:
    """What is left at the best gain and offset near a first fit; the landscape is rough, so all are tried."""
    best, middle = tuple(start), float(original.middle.mean())
    for step in (0.002, 0.001, 0.0005):
        before, gain, offset = best
        for turn in (-step, 0.0, step):
            for shift in (-100 * step, 0.0, 100 * step):
                trial = (gain + turn, offset - turn * middle + shift)
                best = min(best, (_left(original, other, *trial, quality), *trial))
        if best[0] > HELPS * before:
            break
    return best[0]
