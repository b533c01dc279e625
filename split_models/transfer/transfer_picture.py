"""A picture of a transfer for a person to judge: touches before and after the transfer, and both backgrounds."""

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
"""Number of touches in the picture."""
HEIGHT = 320
"""Height in px of each touch and background."""
MARGIN = 8
CAPTION = 22


def write_transfer_picture(source: Store, made: Store, target_background: PictureArray, path: Path) -> Path:
    """Write a PNG with a row for each of a few touches: source background, touch, transferred touch, target background.

    Each row is the frame with the largest force of a trajectory; the trajectories are spread over the store.

    Parameters
    ----------
    source, made : Store
        The store that was transferred, and the resulting store.
    target_background : (H, W, 3) uint8 RGB
        The target without contact.
    path : Path
        File to write, which is returned.
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
    """A white sheet with rows of captioned pictures, all scaled to one height; they may differ in size."""
    drawn = [np.hstack([_captioned(*cell) for cell in cells]) for cells in rows]
    width = max(row.shape[1] for row in drawn)
    return np.vstack([cv2.copyMakeBorder(row, 0, 0, 0, width - row.shape[1], 0, value=(255,) * 3) for row in drawn])


def _captioned(words: str, picture: PictureArray) -> PictureArray:
    """The picture, scaled to `HEIGHT`, with margins and a caption above."""
    scale = HEIGHT / picture.shape[0]
    shown = cv2.resize(picture, (round(picture.shape[1] * scale), HEIGHT), interpolation=cv2.INTER_AREA)
    framed = cv2.copyMakeBorder(shown, CAPTION, MARGIN, MARGIN, MARGIN, cv2.BORDER_CONSTANT, value=(255,) * 3)
    plain = words.encode("ascii", "replace").decode()  # OpenCV's font has ASCII characters only
    cv2.putText(framed, plain, (MARGIN, CAPTION - 6), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (0, 0, 0), 1, cv2.LINE_AA)
    return np.asarray(framed, np.uint8)


def _touches(made: Store) -> list[int]:
    """Rows of frames to show, one for each of a few trajectories: that of the largest force, or the middle one."""
    table = made.trajectories(["frame_start", "frame_stop"]).to_pylist()
    force = np.asarray(made.frames(["contact_force"])["contact_force"].to_numpy(), np.float64)
    chosen = np.unique(np.linspace(0, len(table) - 1, ROWS).astype(int))
    frames = []
    for number in chosen:
        start, stop = table[number]["frame_start"], table[number]["frame_stop"]
        known = np.isfinite(force[start:stop])
        frames.append(start + int(np.nanargmax(force[start:stop])) if known.any() else (start + stop) // 2)
    return frames
