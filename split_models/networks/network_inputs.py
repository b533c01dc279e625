"""What a network may be given: checked before it runs, without PyTorch."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactiledata.errors import UsageError


def require_displacements(vertices: int, displacements: Any) -> None:
    """Nothing, where displacements are (n, vertices, 3) and finite; else `UsageError`."""
    shape = np.shape(displacements)
    if len(shape) != 3 or shape[1:] != (vertices, 3):
        raise UsageError(
            f"displacements of shape {shape}",
            f"(n, {vertices}, 3): the mesh topology that the network was trained on",
            "Replay the store with the resolution, --keep and pad of the training store.",
        )
    if not np.isfinite(displacements).all():
        raise UsageError("displacements with NaN", "frames with a mesh", "Leave frames without a mesh out.")


def require_pictures(size: tuple[int, int], pictures: Any) -> None:
    """Nothing, where pictures are (n, h, w, 3), uint8, of a size (h, w); else `UsageError`."""
    shape = np.shape(pictures)
    if len(shape) != 4 or shape[1:] != (*size, 3) or pictures.dtype != np.uint8:
        raise UsageError(
            f"pictures of shape {shape}, {getattr(pictures, 'dtype', type(pictures).__name__)}",
            f"(n, {size[0]}, {size[1]}, 3), uint8: the size that the network was trained on",
            "Scale the pictures, the background as well.",
        )
