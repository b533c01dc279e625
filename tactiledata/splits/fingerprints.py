"""A small fingerprint of each image, blind to compression and brightness, and the search for pairs that are near.

A fingerprint is the image's luma in 16 x 12 blocks, its mean taken away and its contrast set to 1. Block means survive
compression (an error of some hundredths of a grey level), and two images of one sensor differ by what was touched: the
sensor's own background cancels in the distance. A copy that is filed under another sensor is found too.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

GRID = (16, 12)
"""Rows and columns of blocks."""
CELLS = GRID[0] * GRID[1]
"""Numbers in a fingerprint."""
RADIUS = 0.04
"""Root-mean-square distance, in units of an image's contrast, up to which a pair is looked at closely. Measured:
copies up to 0.016 (DIGIT, contrast 40 grey levels) and 0.030 (GelSight, contrast 10); docs/splits.md."""
NEIGHBOURS = 4
"""Nearest images in the other partition that are looked at, for each image."""
AXES = 16
"""Principal axes in which the search runs; distances only shrink in them, so nothing near is lost."""
MIN_CONTRAST = 1.0
"""Grey levels; below, an image is blank and has no fingerprint."""
LUMA = np.array([0.299, 0.587, 0.114], np.float32)
"""Weights of R, G, B in luma (ITU-R BT.601, the weights of JPEG)."""


@dataclass(frozen=True)
class NearPairs:
    """Pairs of images in different partitions whose fingerprints are near, nearest first.

    Parameters
    ----------
    first, second : (n,) int64
        Rows into the fingerprints.
    distance : (n,) float64
        Root-mean-square, in units of contrast.
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    distance: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.first)

    def only(self, chosen: NDArray[np.bool_]) -> NearPairs:
        """Return the pairs that are chosen (n,)."""
        return NearPairs(self.first[chosen], self.second[chosen], self.distance[chosen])


def fingerprint(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Fingerprint (192,) of an image (H, W, 3) uint8 RGB; NaN where the image is blank."""
    blocks = cv2.resize(image.astype(np.float32), GRID[::-1], interpolation=cv2.INTER_AREA) @ LUMA
    contrast = float(blocks.std())
    if contrast < MIN_CONTRAST:
        return np.full(CELLS, np.nan, np.float32)
    return ((blocks - blocks.mean()) / contrast).reshape(-1).astype(np.float32)


def near_pairs(prints: NDArray[np.float32], part: NDArray[np.int64], radius: float = RADIUS) -> NearPairs:
    """Return pairs of different partitions that are nearer than ``radius``, at most `NEIGHBOURS` for each image.

    Parameters
    ----------
    prints : (n, 192) float32
        Fingerprints; rows with NaN are left out.
    part : (n,) int
        Partition of each, -1 for none.
    radius : float
        Largest root mean square difference of two fingerprints, whose contrast is 1.
    """
    from scipy.spatial import cKDTree

    usable = np.flatnonzero(np.isfinite(prints).all(axis=1) & (part >= 0))
    if len(usable) < 2:
        return NearPairs(np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0))
    flat = principal_axes(prints[usable])
    reach = radius * np.sqrt(prints.shape[1])
    found: list[NDArray[np.int64]] = []
    codes = np.unique(part[usable])
    members = {code: np.flatnonzero(part[usable] == code) for code in codes}
    trees = {code: cKDTree(flat[rows]) for code, rows in members.items()}
    for at, one in enumerate(codes):
        for other in codes[at + 1 :]:
            # ask from the smaller side: each of its images has its nearest on the larger
            few, many = (one, other) if len(members[one]) <= len(members[other]) else (other, one)
            neighbours = min(NEIGHBOURS, len(members[many]))
            near = trees[many].query(flat[members[few]], k=neighbours, distance_upper_bound=reach)[1]
            near = near.reshape(len(members[few]), -1)
            row, column = np.nonzero(near < len(members[many]))
            found.append(np.stack([members[few][row], members[many][near[row, column]]]))
    pairs = np.concatenate(found, axis=1) if found else np.empty((2, 0), np.int64)
    first, second = usable[pairs[0]], usable[pairs[1]]
    distance = np.sqrt(np.mean((prints[first].astype(float) - prints[second]) ** 2, axis=1))
    order = np.lexsort((second, first, distance))
    order = order[distance[order] <= radius]
    return NearPairs(first[order], second[order], distance[order])


def principal_axes(prints: NDArray[np.float32]) -> NDArray[np.float32]:
    """Coordinates (n, `AXES`) of fingerprints (n, k) along the directions in which they differ most."""
    centred = prints - prints.mean(axis=0)
    covariance = centred.T @ centred
    _, vectors = np.linalg.eigh(covariance.astype(np.float64))
    return np.ascontiguousarray(centred @ vectors[:, -AXES:].astype(np.float32))
