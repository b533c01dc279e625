"""Tiny faithful fakes of ObjectFolder-Real: numbered objects, trials and PNGs, with missing folders and odd names."""

from pathlib import Path

import cv2
import numpy as np


def write(folder, rng, *, objects=(1, 2, 10), trials=2, frames=12, **faults):
    """Objects below ``folder``; returns it.

    Faults: ``odd_trial`` (a name), ``missing_trial``, ``empty_object``, ``copies``, ``gap``, ``cut``, ``odd_image``.
    """
    root = Path(folder) / "objectfolder_real"
    for thing in objects:
        for trial in range(1, trials + 1):
            home = root / str(thing) / "tactile_data" / str(trial) / "0" / "gelsight"
            home.mkdir(parents=True)
            (home.parent / "in_hand_camera").mkdir()
            for frame in range(frames):
                if frame != faults.get("gap"):
                    _png(home / f"{frame}.png", rng)
            if faults.get("copies"):
                (home / "0.jpg").write_bytes(b"a copy")
            if faults.get("cut"):
                path = home / "3.png"
                path.write_bytes(path.read_bytes()[:-20])
            if faults.get("odd_image"):
                (home / "4.png").write_bytes(b"no picture")
        if faults.get("odd_trial"):
            odd = root / str(thing) / "tactile_data" / faults["odd_trial"] / "0" / "gelsight"
            odd.mkdir(parents=True)
            _png(odd / "0.png", rng)
        if faults.get("missing_trial"):
            (root / str(thing) / "tactile_data" / "99" / "0").mkdir(parents=True)
    if faults.get("empty_object"):
        (root / "55" / "visual_data").mkdir(parents=True)
    return root


def _png(path, rng):
    cv2.imwrite(str(path), rng.integers(0, 255, (24, 32, 3), dtype=np.uint8))
