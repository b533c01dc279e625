"""Whether one image is a copy of another (compressed again, brighter) or a second picture of the same touch.

A rig that comes back to the same place takes pictures that look alike, and a model may well be tested on one and
trained on the other; what tells a copy is the noise. So one image is turned into what the other would be if it were
its copy: brightness is fitted, and it is compressed as the other was (the quality is recovered from the pixels:
compressing an image again at its own quality changes nothing). What then still differs is measured against what a
second recording's own noise would leave after the same compression. A copy leaves next to nothing, a second recording
about as much as its noise does.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.splits.fingerprints import LUMA

Luma = NDArray[np.float32]
Picture = NDArray[np.uint8]

MARGIN = 16
"""Pixels; crops keep to the grid of compression blocks (8, or 16 with subsampled colour)."""
CROP = (192, 144)
"""Rows and columns, at most, of the middle of an image that is compared."""
JPEG_QUALITY = cv2.IMWRITE_JPEG_QUALITY
GRAIN_OF_COLOUR = 1.65
"""Noise of one colour over that of luma's fine grain: luma averages three colours (0.67), blurring takes some too."""
QUALITIES = range(50, 100)
"""Qualities that are tried (libjpeg's scale)."""
IDEMPOTENT = 0.35
"""Grey levels: compressing again at an image's own quality changes it by less than this on average (rounding)."""
TRIFLE = 0.06
"""Grey levels: what is left by rounding alone; below, two images are the same whatever their noise."""
COPY_RATIO = 0.45
"""What is left, over what a second recording's noise would leave: copies measured below, recordings above (see
docs/splits.md)."""
MOST_LOST = 4.0
"""Grey levels that compression at the lowest quality tried takes from a tactile image, and some more."""
HOPELESS = 2.5
"""A ratio above which fitting brightness more finely cannot help."""
NOISE_OF_TWO = 1.5
"""Two recordings differ by √2 of the noise; the estimate from compressed pixels is somewhat low."""


@dataclass(frozen=True)
class Comparison:
    """How two images compare.

    Parameters
    ----------
    left : float
        Root-mean-square difference, grey levels, after brightness and compression are accounted for.
    expected : float
        The same for a second recording with the first's noise.
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


def compare_images(one: NDArray[np.uint8], other: NDArray[np.uint8]) -> Comparison:
    """How two images (H, W, 3) uint8 RGB compare, whichever of them is the original."""
    if one.shape != other.shape:
        return Comparison(np.inf, 1.0)
    first, second = middle_of(one), middle_of(other)
    forth = _compare(first, second)
    if forth.is_copy:
        return forth
    return min(forth, _compare(second, first), key=lambda found: found.ratio)


def middle_of(image: Picture) -> Picture:
    """The middle (h, w, 3) of an image, on the grid of compression blocks."""
    tops = [max(0, (size - crop) // 2) // MARGIN * MARGIN for size, crop in zip(image.shape, CROP, strict=False)]
    return np.ascontiguousarray(image[tops[0] : tops[0] + CROP[0], tops[1] : tops[1] + CROP[1]])


def compress(picture: Picture, quality: int) -> Picture:
    """A picture, (h, w, 3) or grey (h, w), after JPEG at a quality; as it came where quality is 0."""
    if not quality:
        return picture
    # cv2 takes B, G, R; compressing treats the colours alike only when they are named right
    _, payload = cv2.imencode(".jpg", picture[..., ::-1] if picture.ndim == 3 else picture, [JPEG_QUALITY, quality])
    mode = cv2.IMREAD_COLOR_RGB if picture.ndim == 3 else cv2.IMREAD_GRAYSCALE
    return np.asarray(cv2.imdecode(payload, mode), np.uint8)


def adjusted(picture: NDArray[np.generic], gain: float, offset: float) -> Picture:
    """A picture with another brightness, rounded as software rounds it."""
    return np.clip(np.rint(picture.astype(np.float32) * gain + offset), 0, 255).astype(np.uint8)


def own_quality(picture: Picture) -> int:
    """The JPEG quality that a picture was last compressed at, from its pixels; 0 where it was not."""
    grey = adjusted(picture.astype(np.float32) @ LUMA, 1.0, 0.0)
    change = [float(np.abs(compress(grey, quality).astype(np.int16) - grey).mean()) for quality in QUALITIES]
    best = int(np.argmin(change))
    return QUALITIES[best] if change[best] < IDEMPOTENT else 0


def brightness_fit(original: Picture, other: Picture) -> tuple[float, float]:
    """Gain and offset (grey levels) with which the original is most like the other, outside saturation."""
    a, b = (
        cv2.GaussianBlur(picture.astype(np.float32) @ LUMA, (0, 0), 3.0).reshape(-1) for picture in (original, other)
    )
    keep = (np.minimum(a, b) > 12) & (np.maximum(a, b) < 243)
    if keep.sum() < 100 or a[keep].std() < 1.0:
        return 1.0, 0.0
    for _ in range(2):
        gain, offset = np.polyfit(a[keep], b[keep], 1)
        off = np.abs(b - (gain * a + offset))
        keep &= off <= 3 * np.median(off[keep]) + 0.01
    return float(gain), float(offset)


def noise_level(picture: Picture) -> float:
    """Standard deviation, grey levels, of the fine grain of each colour, by its median: edges do not count."""
    fine = picture.astype(np.float32) @ LUMA
    fine -= cv2.GaussianBlur(fine, (0, 0), 1.5)
    return float(GRAIN_OF_COLOUR * 1.4826 * np.median(np.abs(fine)))


def difference(one: Picture, other: Picture) -> float:
    """Root-mean-square difference of two pictures' luma, grey levels."""
    return float(np.sqrt(np.mean(((one.astype(np.float32) - other) @ LUMA) ** 2)))


def _compare(original: Picture, other: Picture) -> Comparison:
    fitted = brightness_fit(original, other)
    noise = noise_level(original)
    if difference(adjusted(original, *fitted), other) > MOST_LOST + 2 * noise:
        return Comparison(np.inf, noise)
    quality = own_quality(other)
    tried = [(_left(original, other, quality, 1.0, 0.0), 1.0, 0.0)]
    tried.append((_left(original, other, quality, *fitted), *fitted))
    left, gain, offset = min(tried)
    grain = np.random.default_rng(0).normal(0, NOISE_OF_TWO * noise, original.shape)
    again = compress(adjusted(original + grain, gain, offset), quality)
    expected = difference(again, compress(adjusted(original, gain, offset), quality))
    rough = Comparison(left, expected)
    if rough.is_copy or rough.ratio > HOPELESS:
        return rough
    return Comparison(_finest(original, other, quality, (left, gain, offset)), expected)


def _left(original: Picture, other: Picture, quality: int, gain: float, offset: float) -> float:
    return difference(compress(adjusted(original, gain, offset), quality), other)


def _finest(original: Picture, other: Picture, quality: int, start: tuple[float, float, float]) -> float:
    """What is left at the best gain and offset near a first fit; the landscape is rough, so all are tried."""
    best, middle = start, float(original.mean())
    for step in (0.004, 0.002, 0.001):
        _, gain, offset = best
        for turn in (-step, 0.0, step):
            for shift in (-100 * step, 0.0, 100 * step):
                trial = (gain + turn, offset - turn * middle + shift)
                best = min(best, (_left(original, other, quality, *trial), *trial))
    return best[0]
