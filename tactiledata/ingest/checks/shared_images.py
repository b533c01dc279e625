"""Touches of different recordings that hold images of the same bytes: a copy keeps these where its times were moved."""

from __future__ import annotations

from collections import Counter
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
    there = frames.filter(pc.not_equal(frames["encoding"].cast(pa.string()), "missing"))
    if not there.num_rows:
        return set()
    facts = np.stack([there[name].to_numpy().astype(np.int64) for name in ("crc32c", "height", "width")], axis=1)
    image = np.unique(facts, axis=0, return_inverse=True)[1].ravel()
    held = np.unique(np.stack([image, there["trajectory"].to_numpy().astype(np.int64)], axis=1), axis=0)
    of_touch = Counter(held[:, 1].tolist())
    begins = np.flatnonzero(np.diff(held[:, 0], prepend=-1))
    shared: Counter[tuple[int, int]] = Counter()
    for start, stop in zip(begins, [*begins[1:], len(held)], strict=True):
        holders = held[start:stop, 1].tolist()
        if 1 < len(holders) <= MOST_HOLDERS:
            shared.update(pair for pair in combinations(holders, 2) if source[pair[0]] != source[pair[1]])
    copies = [
        pair
        for pair, count in shared.items()
        if count >= LEAST_SHARED and count >= COPIED * min(of_touch[row] for row in pair)
    ]
    return {pair for one, other in copies for pair in ((one, other), (other, one))}
