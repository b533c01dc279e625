"""Sizes of the images of one sensor in one recording: which are strays among the others."""

from __future__ import annotations

from collections.abc import Mapping

Size = tuple[int, int]
"""Height and width, pixels."""

STRAY_SHARE = 0.1
"""Largest share of a sensor's images in a recording that a stray size has; more of them were set so."""


def usual_size(counts: Mapping[Size, int]) -> Size:
    """The size that most images have, from the number of images by size."""
    return max(counts, key=lambda size: counts[size])


def stray_sizes(counts: Mapping[Size, int]) -> set[Size]:
    """The sizes that are strays: one image, or a tenth of the images at most, where more than half have one size.

    Parameters
    ----------
    counts : dict, (height, width) -> number of images

    Examples
    --------
    >>> stray_sizes({(320, 240): 39, (3200, 2400): 1})
    {(3200, 2400)}
    >>> stray_sizes({(320, 240): 20, (640, 480): 20})
    set()
    """
    total = sum(counts.values())
    if not total or 2 * counts[usual_size(counts)] <= total:
        return set()
    most = max(1, int(STRAY_SHARE * total))
    return {size for size, count in counts.items() if count <= most and size != usual_size(counts)}


def words_of(size: Size) -> str:
    """A size in words: rows x columns."""
    return f"{size[0]} x {size[1]}"


def share_words(count: int, total: int, size: Size) -> str:
    """How many images have a size, in words that agree in number: ``"1 of 40 images is 3200 x 2400"``.

    Parameters
    ----------
    count : int
        Images that have the size.
    total : int
        All images.
    size : (height, width), pixels
    """
    return f"{count} of {total} images {'is' if count == 1 else 'are'} {words_of(size)}"
