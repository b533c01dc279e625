"""How far a predicted mesh is from the true one, node by node, in millimetres."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactiledata.metrics.base import Score, Values, metric, number_pairs

AXES = ("n", "vertices", "3")
MILLIMETRES = 1e3
"""Tables of meshes are in mm, as the field prints them; inputs are metres."""


def rmse(predicted: Any, true: Any, mask: Any = None) -> Values:
    """Root mean square (n,), mm, over all components of all nodes."""
    ours, theirs = number_pairs(predicted, true, AXES)
    return MILLIMETRES * np.sqrt(np.square(ours - theirs).mean(axis=(1, 2)))


def l1(predicted: Any, true: Any, mask: Any = None) -> Values:
    """Mean absolute difference (n,), mm, over all components of all nodes."""
    ours, theirs = number_pairs(predicted, true, AXES)
    return MILLIMETRES * np.abs(ours - theirs).mean(axis=(1, 2))


def euclidean(predicted: Any, true: Any, mask: Any = None) -> Values:
    """Mean distance (n,), mm, from each node to its true place."""
    ours, theirs = number_pairs(predicted, true, AXES)
    return MILLIMETRES * np.linalg.norm(ours - theirs, axis=2).mean(axis=1)


MESH_DISTANCE = metric(
    "mesh_distance",
    "how far nodes are from their true places; meshes (n, V, 3) m, displacements or places",
    "meshes",
    [
        Score("rmse", "RMSE", "mm", "lower", 0.0, rmse),
        Score("l1", "l1", "mm", "lower", 0.0, l1),
        Score("euclidean", "Euclidean distance", "mm", "lower", 0.0, euclidean),
    ],
)
