"""Real DIGIT contacts transferred to five real backgrounds by every method that needs no model: a picture.

    python benchmarks/transfer_real_contacts.py [--contacts tests/data/digit_contact] [--model CHECKPOINT]
        [--out docs/images/transfer-real-contacts.jpg]

The contacts' authors published no picture of their sensor without contact. It is filled in here: what their mask of the
first contact covers, widened, from its surroundings. What is inside is a guess, and the same for both contacts.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import numpy as np

from split_models.transfer.methods import LATENT, transfer_method
from tactiledata.sensors.backgrounds import load_background

TARGETS = ("ycb-sensorA", "ycb-sensorB", "digit-bg-6", "digit-bg-9", "digit-bg-12")
METHODS = ("background_swap", "background_ratio", "histogram_matching", "reinhard", "fourier")
CONTACTS = ("digit_raw", "limitation_raw_digit")
SCALE = 0.34
GAP = 3


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--contacts", type=Path, default=Path("tests/data/digit_contact"))
    parser.add_argument("--model", type=Path, help="an image VAE: adds the methods that need one")
    parser.add_argument("--out", type=Path, default=Path("docs/images/transfer-real-contacts.jpg"))
    given = parser.parse_args()
    touches = np.stack([read(given.contacts / f"{name}.png") for name in CONTACTS])
    background = filled_in(touches[0], given.contacts / "digit_mask.png")
    methods = [transfer_method(name) for name in METHODS]
    if given.model:
        methods += [transfer_method(name, given.model) for name in LATENT]
    rows = [line("without contact", [background, *map(load_background, TARGETS)])]
    moved = {
        (method.name, target): method.transfer(touches, background, load_background(target))
        for method in methods
        for target in TARGETS
    }
    for number, touch in enumerate(touches):
        for method in methods:
            cells = [touch, *(moved[method.name, target][number] for target in TARGETS)]
            rows.append(line(f"contact {number + 1}, {method.name.replace('_', ' ')}", cells))
    given.out.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(given.out), np.vstack(rows)[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 90])
    print(f"{given.out}: {given.out.stat().st_size / 1e3:.0f} kB")


def read(path: Path) -> np.ndarray:
    """A picture (H, W, 3) RGB."""
    image = cv2.imread(str(path), cv2.IMREAD_COLOR_RGB)
    if image is None:
        raise SystemExit(f"{path} is not there, or no picture")
    return image


def filled_in(contact: np.ndarray, mask_path: Path) -> np.ndarray:
    """The sensor without the contact, as far as its surroundings tell."""
    mask = cv2.resize(cv2.imread(str(mask_path), cv2.IMREAD_GRAYSCALE), (240, 320), interpolation=cv2.INTER_NEAREST)
    wide = cv2.dilate((mask > 0).astype(np.uint8), np.ones((25, 25), np.uint8))
    return cv2.inpaint(contact, wide, 15, cv2.INPAINT_TELEA)


def line(words: str, cells: list[np.ndarray]) -> np.ndarray:
    """Pictures side by side under a caption."""
    small = [cv2.resize(cell, None, fx=SCALE, fy=SCALE, interpolation=cv2.INTER_AREA) for cell in cells]
    framed = [cv2.copyMakeBorder(one, 0, GAP, GAP, GAP, cv2.BORDER_CONSTANT, value=(255,) * 3) for one in small]
    pictures = np.hstack(framed)
    caption = np.full((15, pictures.shape[1], 3), 255, np.uint8)
    cv2.putText(caption, words, (GAP, 11), cv2.FONT_HERSHEY_SIMPLEX, 0.36, (0, 0, 0), 1, cv2.LINE_AA)
    return np.vstack([caption, pictures])


if __name__ == "__main__":
    main()
