"""A grid of pictures in one file, with titles over the columns and beside the rows."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from tactiledata.arrays import PictureArray
from tactiledata.contract.atomic import write_atomic

LEAST_WIDTH = 150
"""Width in px below which pictures are enlarged by a whole factor, so that titles fit over them."""
GAP = 4
"""Pixels between pictures."""
LINE = 15
"""Pixels from one line of text to the next."""
FONT, SIZE = cv2.FONT_HERSHEY_SIMPLEX, 0.42
BACKDROP, INK = 255, 30


def write_grid(
    path: Path,
    rows: Sequence[Sequence[PictureArray]],
    columns: Sequence[str] = (),
    labels: Sequence[str] = (),
) -> None:
    """Write a PNG with rows of pictures (h, w, 3), uint8, all of one size.

    Parameters
    ----------
    path : Path
    rows : sequence of sequences of pictures
        The grid, row by row.
    columns, labels : sequences of str
        Titles over the columns, and to the left of the rows; none unless given.
    """
    times = -(-LEAST_WIDTH // rows[0][0].shape[1])
    enlarged = [[picture.repeat(times, axis=0).repeat(times, axis=1) for picture in row] for row in rows]
    bodies = [_joined(row, axis=1) for row in enlarged]
    width = enlarged[0][0].shape[1]
    if labels:
        beside = [_worded(text, LEAST_WIDTH, body.shape[0]) for text, body in zip(labels, bodies, strict=True)]
        bodies = [_joined(pair, axis=1) for pair in zip(beside, bodies, strict=True)]
    if columns:
        height = LINE * max(len(_lines(text, width)) for text in columns) + LINE // 2
        heads = [_worded(text, width, height) for text in columns]
        corner = [_worded("", LEAST_WIDTH, height)] if labels else []
        bodies.insert(0, _joined([*corner, *heads], axis=1))
    _, encoded = cv2.imencode(".png", _joined(bodies, axis=0)[..., ::-1])
    write_atomic(path, encoded.tobytes())


def _joined(pictures: Sequence[PictureArray], axis: int) -> PictureArray:
    """Pictures side by side along an axis, with a gap between them."""
    shape = list(pictures[0].shape)
    shape[axis] = GAP
    gap = np.full(shape, BACKDROP, np.uint8)
    parts = [part for picture in pictures for part in (picture, gap)]
    return np.concatenate(parts[:-1], axis=axis)


def _worded(text: str, width: int, height: int) -> PictureArray:
    """A plain picture (height, width, 3) with text from the top."""
    plain = np.full((height, width, 3), BACKDROP, np.uint8)
    for number, line in enumerate(_lines(text, width)):
        cv2.putText(plain, line, (2, LINE * (number + 1) - 3), FONT, SIZE, (INK, INK, INK), 1, cv2.LINE_AA)
    return plain


def _lines(text: str, width: int) -> list[str]:
    """Text in lines that fit a width in px; line breaks are kept, and a word that is too long gets its own line."""
    lines: list[str] = []
    for part in text.split("\n"):
        line = ""
        for word in part.split():
            longer = f"{line} {word}".strip()
            if line and cv2.getTextSize(longer, FONT, SIZE, 1)[0][0] > width - 4:
                lines.append(line)
                longer = word
            line = longer
        lines.append(line)
    return lines
