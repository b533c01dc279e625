"""Tiny faithful fakes of TVL: pictures that look like a DIGIT's and like photographs, lists with the corpus' traps."""

import csv
import json
from functools import cache
from pathlib import Path

import cv2
import numpy as np


def write(folder, rng, *, parts=("data1",), sequences=3, frames=6, ssvtp=4, swapped=(), **faults):
    """``tvl_dataset/`` below ``folder``; returns it. ``swapped``: numbers of sequences with exchanged folders.

    Faults: ``empty_cell`` (tactile, vision or caption), ``escape``, ``drop_image``, ``short_list``, ``no_csv``,
    ``broken_json``.
    """
    root = Path(folder) / "tvl_dataset"
    for part in parts:
        _hct(root / "hct" / part, rng, sequences, frames, swapped, faults)
    if ssvtp:
        _ssvtp(root / "ssvtp", rng, ssvtp)
    return root


@cache
def _light():
    """Three colours from three sides, (320, 240, 3)."""
    y, x = np.mgrid[0:320, 0:240] / 320.0
    centres = ((0.0, 0.37), (0.8, 0.0), (0.8, 0.75))
    field = np.stack([np.exp(-((y - cy) ** 2 + (x - cx) ** 2) / 0.15) for cy, cx in centres], axis=2)
    return (60 + 150 * field).astype(np.uint8)


def touch_picture(rng, press=0.0):
    """A picture (320, 240, 3), RGB, like a DIGIT's: three colours from three sides, smooth, a smooth dent."""
    picture = _light().copy()
    if press:
        top, left = rng.integers(60, 160), rng.integers(50, 120)
        window = np.hanning(70)[:, None, None] * np.hanning(70)[None, :, None]
        patch = picture[top : top + 70, left : left + 70]
        patch[:] = np.clip(patch + 40 * press * window, 0, 255).astype(np.uint8)
    return picture + rng.integers(0, 3, picture.shape, dtype=np.uint8)


def photograph(rng, size=(120, 213)):
    """A picture like a photograph: grey-brown, edges and texture everywhere, another one every time."""
    picture = np.full((*size, 3), rng.integers(60, 160), dtype=np.uint8)
    for _ in range(40):
        corner = rng.integers(0, size)
        extent = rng.integers(3, 45, size=2)
        colour = (rng.uniform(20, 200) * np.array([1.0, 0.95, 0.85])).astype(np.uint8)
        picture[corner[0] : corner[0] + extent[0], corner[1] : corner[1] + extent[1]] = colour
    return picture + rng.integers(0, 40, picture.shape, dtype=np.uint8)


def _hct(home, rng, sequences, frames, swapped, faults):
    rows, free = [], {"vision": [], "tactile": [], "background": []}
    for number in range(sequences):
        name = f"{number}-{1702507215.615537 + number:.6f}"
        for frame in range(frames):
            stem = f"{frame}-{0.017 * frame:.12f}.jpg"
            pictures = {"tactile": touch_picture(rng, press=frame > 0), "vision": photograph(rng)}
            if number in swapped:
                pictures = {"tactile": pictures["vision"], "vision": pictures["tactile"]}
            for kind, picture in pictures.items():
                _save(home / name / kind / stem, picture)
            paths = {kind: f"{name}/{kind}/{stem}" for kind in pictures}
            paths["background"] = f"{name}/tactile/0-{0.0:.12f}.jpg"
            if frame == 0:
                for kind, path in paths.items():
                    free[kind].append(path)
            else:
                rows.append({**paths, "caption": f"smooth, {'hard' if number else 'soft'}, cool"})
    if faults.get("drop_image"):
        (home / rows[0]["tactile"]).unlink()
    if faults.get("empty_cell"):
        rows[0][faults["empty_cell"]] = ""
    if faults.get("escape"):
        rows[0]["tactile"] = faults["escape"]
    if faults.get("short_list"):
        free["vision"].pop()
    _lists(home, rows, free, faults)


def _lists(home, rows, free, faults):
    contact = {kind: [row[kind] for row in rows] for kind in ("vision", "tactile", "background")}
    (home / "contact.json").write_text(json.dumps(contact))
    (home / "not_contact.json").write_text("{" if faults.get("broken_json") else json.dumps(free))
    if faults.get("no_csv"):
        return
    for table, chosen in (("train.csv", rows[::2]), ("test.csv", rows[1::2])):  # sequences lie on both sides
        with (home / table).open("w", newline="") as stream:
            writer = csv.DictWriter(stream, ["vision", "tactile", "background", "caption"])
            writer.writeheader()
            writer.writerows(chosen)


def _ssvtp(home, rng, presses):
    rows = []
    for number in range(presses):
        _save(home / "images_tac" / f"image_{number}_tac.jpg", touch_picture(rng, press=1.0))
        _save(home / "images_rgb" / f"image_{number}_rgb.jpg", photograph(rng))
        (home / "text").mkdir(exist_ok=True)
        (home / "text" / f"labels_{number}.txt").write_text("rough, fabric\n")
        rows.append((f"images_rgb/image_{number}_rgb.jpg", f"images_tac/image_{number}_tac.jpg", "rough, fabric"))
    with (home / "train.csv").open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(("url", "tactile", "caption"))
        writer.writerows(rows[:-1])  # the last press is in no table


def _save(path, picture):
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), picture[:, :, ::-1])
