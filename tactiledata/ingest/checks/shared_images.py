"""Touches of different recordings that hold images of the same bytes: a copy keeps these where its times were moved."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import combinations

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

IMAGE_COLUMNS = ("trajectory", "height", "width", "crc32c", "encoding")
"""Columns of the table of frames that tell whether two images are of the same bytes."""

LEAST_SHARED = 3
"""Different images that a copy shares with its original, at least: one blank picture may be that of many recordings."""

COPIED = 0.5
"""Share of the different images of a touch that another must hold, too."""

MOST_HOLDERS = 20
"""Touches that hold an image, at most, where it tells a copy: what more hold is a picture without a scene."""


def image_words(frames: pa.Table) -> tuple[pa.Table, NDArray[np.uint64]]:
    """Rows of a table of frames that hold an image, and a number (n,) for each, equal where bytes and size are equal.

    Parameters
    ----------
    frames : pa.Table
        ``height``, ``width``, ``crc32c`` and ``encoding`` among its columns.
    """
    there = frames.filter(pc.not_equal(frames["encoding"].cast(pa.string()), "missing"))
    crc, height, width = (there[name].to_numpy().astype(np.uint64) for name in ("crc32c", "height", "width"))
    return there, crc | height << np.uint64(32) | width << np.uint64(48)


def touches_of_same_images(frames: pa.Table, source: NDArray[np.int64]) -> set[tuple[int, int]]:
    """Rows of two touches of different recordings that share images, both ways round.

    Parameters
    ----------
    frames : pa.Table
        The columns `IMAGE_COLUMNS` of a store, n rows.
    source : (n_trajectories,) int
        Recording of each touch.

    Returns
    -------
    set of (row, row)
        Pairs of touches that share three different images at least, and half of those of one of the two.
    """
    there, image = image_words(frames)
    touch = there["trajectory"].to_numpy()
    # few images come twice; only those need a group
    order = np.argsort(image, kind="stable")
    again = image[order][1:] == image[order][:-1]
    rows = order[np.concatenate([again, [False]]) | np.concatenate([[False], again])] if len(order) else order
    held = np.unique(np.rec.fromarrays([image[rows], touch[rows]]))
    shared: Counter[tuple[int, int]] = Counter()
    for start, stop in _runs(held["f0"]):
        holders = held["f1"][start:stop].tolist()
        if 1 < len(holders) <= MOST_HOLDERS:
            shared.update(pair for pair in combinations(holders, 2) if source[pair[0]] != source[pair[1]])
    shared = Counter({pair: count for pair, count in shared.items() if count >= LEAST_SHARED})
    asked = np.isin(touch, list({row for pair in shared for row in pair}))
    of_touch = Counter(np.unique(np.rec.fromarrays([touch[asked], image[asked]]))["f0"].tolist())
    copies = [pair for pair, count in shared.items() if count >= COPIED * min(of_touch[row] for row in pair)]
    return {pair for one, other in copies for pair in ((one, other), (other, one))}


def _runs(values: NDArray[np.uint64]) -> Iterator[tuple[int, int]]:
    """Yield first and end of each stretch of equal values (n,)."""
    ends = [*(np.flatnonzero(values[1:] != values[:-1]) + 1).tolist(), len(values)]
    yield from zip([0, *ends[:-1]], ends, strict=True) if len(values) else ()
