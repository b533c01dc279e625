"""Checks of what a network is given, before it runs; they do not need PyTorch."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactiledata.errors import UsageError


def require_displacements(vertices: int, displacements: Any) -> None:
    """Refuse displacements that are not (n, vertices, 3) or not finite.

    Raises
    ------
    UsageError
        The shape differs, or a value is NaN or infinite.
    """
    shape = np.shape(displacements)
    if len(shape) != 3 or shape[1:] != (vertices, 3):
        raise UsageError(
            f"displacements of shape {shape}",
            f"(n, {vertices}, 3): the mesh topology that the network was trained on",
            "Replay the store with the resolution, --keep and pad of the training store.",
        )
    if not np.isfinite(displacements).all():
        raise UsageError("displacements with NaN", "frames with a mesh", "Leave out frames without a mesh.")


def require_pictures(size: tuple[int, int], pictures: Any) -> None:
    """Refuse pictures that are not (n, h, w, 3), uint8, of the given size (h, w).

    Raises
    ------
    UsageError
        The shape or the type differs.
    """
    shape = np.shape(pictures)
    if len(shape) != 4 or shape[1:] != (*size, 3) or pictures.dtype != np.uint8:
        raise UsageError(
            f"pictures of shape {shape}, {getattr(pictures, 'dtype', type(pictures).__name__)}",
            f"(n, {size[0]}, {size[1]}, 3), uint8: the size that the network was trained on",
            "Scale the pictures, the background as well.",
        )
