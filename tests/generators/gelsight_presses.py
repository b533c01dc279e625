"""Small calibration packs of the published layout, sound or with a fault.

Run as a script to look at one: ``python gelsight_presses.py FILE``.
"""

import sys

import numpy as np

SHAPE = (120, 160)
"""Rows and columns of the published pack: only for these is the length of a pixel known."""


def arrays(presses=5, shape=SHAPE, seed=0):
    """The arrays of a sound pack: radii below the ball's own."""
    rng = np.random.default_rng(seed)
    background = rng.integers(90, 110, (*shape, 3), dtype=np.uint8)
    background[..., 0] += 50  # BGR: blue
    images = np.repeat(background[None], presses, axis=0)
    centres = rng.uniform(30, min(shape) - 30, (presses, 2)).round(1)
    for image, (column, row) in zip(images, centres.astype(int), strict=True):
        image[row - 8 : row + 8, column - 8 : column + 8, 2] = 250  # BGR: red
    return {
        "f0": background,
        "imgs": images,
        "touch_center": centres,
        "touch_radius": rng.integers(6, 16, presses),
        "names": np.array([f"frame_{index + 1}.jpg" for index in range(presses)]),
        "img_size": np.array([*shape, 3]),
    }


def write(path, *, without=(), **changed):
    """A pack with some arrays left out or replaced; returns what was written."""
    packed = {name: value for name, value in {**arrays(), **changed}.items() if name not in without}
    np.savez(path, **packed)
    return packed


if __name__ == "__main__":
    write(sys.argv[1])
