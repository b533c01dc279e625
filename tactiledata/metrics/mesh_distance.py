"""Distances of a predicted mesh from the true one, node by node, in millimetres."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactiledata.metrics.base import Score, Values, metric, number_pairs

AXES = ("n", "vertices", "3")
"""Axes of a batch of meshes."""
MILLIMETRES = 1e3
"""Factor from metres to millimetres: inputs are in m, tables of meshes in mm, as in the literature."""


def rmse(predicted: Any, true: Any, mask: Any = None) -> Values:
    """Root mean square (n,), mm, of the errors of all components of all nodes.

    Parameters
    ----------
    predicted, true : (n, V, 3), m
        Nodes or displacements, mesh by mesh.
    mask : ignored
        Meshes have no mask.
    """
    ours, theirs = number_pairs(predicted, true, AXES)
    return MILLIMETRES * np.sqrt(np.square(ours - theirs).mean(axis=(1, 2)))


def l1(predicted: Any, true: Any, mask: Any = None) -> Values:
    """Mean absolute error (n,), mm, of all components of all nodes.

    Parameters
    ----------
    predicted, true : (n, V, 3), m
        Nodes or displacements, mesh by mesh.
    mask : ignored
        Meshes have no mask.
    """
    ours, theirs = number_pairs(predicted, true, AXES)
    return MILLIMETRES * np.abs(ours - theirs).mean(axis=(1, 2))


def euclidean(predicted: Any, true: Any, mask: Any = None) -> Values:
    """Mean distance (n,), mm, of the nodes from their true places.

    Parameters
    ----------
    predicted, true : (n, V, 3), m
        Nodes or displacements, mesh by mesh.
    mask : ignored
        Meshes have no mask.
    """
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
