"""A picture of a transfer for a person to judge: touches before and after the transfer, and both backgrounds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from split_models.transfer.transfer_take import PARENT
from tactiledata.arrays import PictureArray
from tactiledata.contract.atomic import write_atomic
from tactiledata.report.plots import difference_picture
from tactiledata.store.read.reader import Store
from tactiledata.store.read.simulated import simulated_recordings
from tactiledata.store.read.targets import Target

ROWS = 4
"""Number of touches in the picture."""
HEIGHT = 320
"""Height in px of each touch and background."""
MARGIN = 8
CAPTION = 22
TITLE = 32
TITLE_SCALE = 0.6
FONT = cv2.FONT_HERSHEY_SIMPLEX


def write_transfer_picture(source: Store, made: Store, target: Target, method: str, path: Path) -> Path:
    """Write a PNG with a row for each of a few touches: pictures before and after the transfer, and what differs.

    A row shows the source untouched, its touch, the transferred touch and the target untouched, and then `differences`.

    Each row is the frame with the largest force of a trajectory; the trajectories are spread over the store. The title
    says which sensor's style was given by which method, and where recordings are simulated.

    Parameters
    ----------
    source, made : Store
        The store that was transferred, and the resulting store.
    target : Target
        The sensor whose style was given.
    method : str
        Name of the method.
    path : Path
        File to write, which is returned.
    """
    sensors = source.frames(["sensor"])["sensor"]
    parents = made.frame_values(PARENT)[:, 0].astype(int)
    rows = []
    for row in _touches(made):
        parent = int(parents[row])
        sensor = str(sensors[parent].as_py())
        untouched, touch = source.reference(sensor).image, np.asarray(source.images([parent])[0])
        transferred = np.asarray(made.images([row])[0])
        rows.append(
            [
                (f"{sensor}, untouched", untouched),
                ("its touch", touch),
                ("transferred", transferred),
                (f"{target.name}, untouched", target.background),
                *differences(untouched, touch, transferred, target.background),
            ]
        )
    title = simulated_recordings(source).titled(f"Touches in the style of {target.name}, by {method.replace('_', '-')}")
    encoded = cv2.imencode(".png", titled(sheet(rows), title)[..., ::-1])[1].tobytes()
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(path, encoded)
    return path


def differences(
    untouched: PictureArray, touch: PictureArray, transferred: PictureArray, target: PictureArray
) -> list[tuple[str, PictureArray]]:
    """Captioned pictures of what a touch changes before and after a transfer, and of where these changes differ.

    All are doubled about grey, which is no difference. The last one is grey where the transfer keeps the touch; it is
    left out where the pictures of both sensors differ in size.

    Parameters
    ----------
    untouched, touch : (H, W, 3) uint8
        Source without and with contact.
    transferred, target : (h, w, 3) uint8
        Transferred touch, and target without contact.
    """
    if untouched.shape != touch.shape or target.shape != transferred.shape:
        return []
    before, after = difference_picture(touch, untouched), difference_picture(transferred, target)
    drawn = [("the touch alone, x2", before), ("the same, transferred", after)]
    if before.shape != after.shape:
        return drawn
    left = np.clip(128 + (after.astype(np.int16) - before), 0, 255).astype(np.uint8)
    return [*drawn, ("where they differ", left)]


def sheet(rows: Sequence[Sequence[tuple[str, PictureArray]]]) -> PictureArray:
    """A white sheet with rows of captioned pictures, all scaled to one height; they may differ in size."""
    drawn = [np.hstack([_captioned(*cell) for cell in cells]) for cells in rows]
    width = max(row.shape[1] for row in drawn)
    return np.vstack([cv2.copyMakeBorder(row, 0, 0, 0, width - row.shape[1], 0, value=(255,) * 3) for row in drawn])


def titled(drawn: PictureArray, title: str) -> PictureArray:
    """A sheet below a line of text, and as wide as that line where it is narrower."""
    needed = cv2.getTextSize(_plain(title), FONT, TITLE_SCALE, 1)[0][0] + 2 * MARGIN
    margins = (TITLE, 0, 0, max(0, needed - drawn.shape[1]))
    framed = cv2.copyMakeBorder(drawn, *margins, cv2.BORDER_CONSTANT, value=(255,) * 3)
    cv2.putText(framed, _plain(title), (MARGIN, TITLE - 10), FONT, TITLE_SCALE, (0, 0, 0), 1, cv2.LINE_AA)
    return np.asarray(framed, np.uint8)


def _captioned(words: str, picture: PictureArray) -> PictureArray:
    """The picture, scaled to `HEIGHT`, with margins and a caption above."""
    scale = HEIGHT / picture.shape[0]
    shown = cv2.resize(picture, (round(picture.shape[1] * scale), HEIGHT), interpolation=cv2.INTER_AREA)
    framed = cv2.copyMakeBorder(shown, CAPTION, MARGIN, MARGIN, MARGIN, cv2.BORDER_CONSTANT, value=(255,) * 3)
    cv2.putText(framed, _plain(words), (MARGIN, CAPTION - 6), FONT, 0.45, (0, 0, 0), 1, cv2.LINE_AA)
    return np.asarray(framed, np.uint8)


def _plain(words: str) -> str:
    """The words in ASCII characters, as OpenCV's font has no others."""
    return words.encode("ascii", "replace").decode()


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
