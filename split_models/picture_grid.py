"""Pictures side by side in one file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.atomic import write_atomic


def write_grid(path: Path, rows: Sequence[Sequence[NDArray[np.uint8]]]) -> None:
    """Rows of pictures (h, w, 3), uint8, all of one size, as a PNG."""
    grid = np.concatenate([np.concatenate(list(row), axis=1) for row in rows])
    _, encoded = cv2.imencode(".png", grid[..., ::-1])
    write_atomic(path, encoded.tobytes())
