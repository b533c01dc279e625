"""A picture of a transfer for a person to judge: touches, what became of them, and both backgrounds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from split_models.transfer.transfer_take import PARENT
from tactiledata.arrays import PictureArray
from tactiledata.contract.atomic import write_atomic
from tactiledata.store.read.reader import Store

ROWS = 4
"""Touches that are shown."""
HEIGHT = 320
"""px of one picture."""
MARGIN = 8
CAPTION = 22


def write_transfer_picture(source: Store, made: Store, target_background: PictureArray, path: Path) -> Path:
    """A PNG with a row for each of a few touches: its background, the touch, the transferred touch, the target.

    Each row is the frame of largest force of one trajectory; trajectories are spread over the store.

    Parameters
    ----------
    source, made : Store
        The store that was transferred, and what came of it.
    target_background : (H, W, 3) uint8 RGB
    path : Path
    """
    sensors = source.frames(["sensor"])["sensor"]
    parents = made.frame_values(PARENT)[:, 0].astype(int)
    rows = []
    for row in _touches(made):
        parent = int(parents[row])
        sensor = str(sensors[parent].as_py())
        rows.append(
            (
                (sensor, source.reference(sensor).image),
                ("touch", np.asarray(source.images([parent])[0])),
                ("transferred", np.asarray(made.images([row])[0])),
                ("target", target_background),
            )
        )
    encoded = cv2.imencode(".png", sheet(rows)[..., ::-1])[1].tobytes()
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(path, encoded)
    return path


def sheet(rows: Sequence[Sequence[tuple[str, PictureArray]]]) -> PictureArray:
    """Captioned pictures of one height in rows, on white; pictures may differ in size."""
    drawn = [np.hstack([_captioned(*cell) for cell in cells]) for cells in rows]
    width = max(one.shape[1] for one in drawn)
    return np.vstack([cv2.copyMakeBorder(o, 0, 0, 0, width - o.shape[1], 0, value=(255,) * 3) for o in drawn])


def _captioned(words: str, picture: PictureArray) -> PictureArray:
    scale = HEIGHT / picture.shape[0]
    shown = cv2.resize(picture, (round(picture.shape[1] * scale), HEIGHT), interpolation=cv2.INTER_AREA)
    framed = cv2.copyMakeBorder(shown, CAPTION, MARGIN, MARGIN, MARGIN, cv2.BORDER_CONSTANT, value=(255,) * 3)
    plain = words.encode("ascii", "replace").decode()  # the font knows no others
    cv2.putText(framed, plain, (MARGIN, CAPTION - 6), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (0, 0, 0), 1, cv2.LINE_AA)
    return np.asarray(framed, np.uint8)


def _touches(made: Store) -> list[int]:
    """Rows of frames: of trajectories spread over the store, the one of largest force, or the middle one."""
    table = made.trajectories(["frame_start", "frame_stop"]).to_pylist()
    force = np.asarray(made.frames(["contact_force"])["contact_force"].to_numpy(), np.float64)
    chosen = np.unique(np.linspace(0, len(table) - 1, ROWS).astype(int))
    found = []
    for number in chosen:
        start, stop = table[number]["frame_start"], table[number]["frame_stop"]
        known = np.isfinite(force[start:stop])
        found.append(start + int(np.nanargmax(force[start:stop])) if known.any() else (start + stop) // 2)
    return found
