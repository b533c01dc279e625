"""How often the audit finds a copied image, and how often it takes a second recording for one, on real pictures.

    python benchmarks/copy_detection.py [--quick]

Copies: each of 49 real GelSight presses and 2 real DIGIT contacts, compressed again (JPEG 75 to 95), made brighter or
darker, or both. Not copies: all pairs of different presses; and the hardest case, one touch recorded twice in exactly
the same pose, made by adding fresh noise twice to a real picture whose own noise was smoothed away.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.splits.copies import COPY_RATIO, Comparison, Portrait, adjusted, compare_images, compress, sensor_noise
from tactiledata.splits.fingerprints import RADIUS, fingerprint

Picture = NDArray[np.uint8]
DATA = Path(__file__).resolve().parents[1] / "tests" / "data"
CHANGES: dict[str, Callable[[Picture], Picture]] = {
    **{f"JPEG {quality}": (lambda picture, q=quality: compress(picture, q)) for quality in (95, 90, 85, 80, 75)},
    "4 % brighter": lambda picture: adjusted(picture, 1.04, 2.0),
    "4 % brighter, JPEG 95": lambda picture: compress(adjusted(picture, 1.04, 2.0), 95),
    "5 % darker, JPEG 85": lambda picture: compress(adjusted(picture, 0.95, 0.0), 85),
    "5 levels brighter, JPEG 75": lambda picture: compress(adjusted(picture, 1.0, 5.0), 75),
}


def gelsight() -> list[Picture]:
    """49 real presses, RGB."""
    with np.load(DATA / "gelsight_r15" / "dataPack.npz", allow_pickle=False) as pack:
        return [np.ascontiguousarray(image[..., ::-1]) for image in pack["imgs"]]


def digit() -> list[Picture]:
    """2 real contacts, RGB."""
    folder = DATA / "digit_contact"
    return [
        cv2.imread(str(folder / name), cv2.IMREAD_COLOR_RGB) for name in ("digit_raw.png", "limitation_raw_digit.png")
    ]


def recorded_twice(picture: Picture, noise: float, quality: int, rng: np.random.Generator) -> list[Picture]:
    """One touch recorded twice in the same pose: the picture without its grain, with fresh grain, compressed."""
    quiet = cv2.GaussianBlur(picture.astype(np.float32), (0, 0), 1.0)
    return [compress(adjusted(quiet + rng.normal(0, noise, quiet.shape), 1.0, 0.0), quality) for _ in range(2)]


def is_found(one: Picture, other: Picture, noise: float) -> tuple[bool, Comparison]:
    """Whether the audit would call a pair a copy: near by fingerprint, then a copy in detail."""
    near = np.sqrt(np.mean((fingerprint(one) - fingerprint(other)) ** 2)) <= RADIUS
    found = compare_images(Portrait(one), Portrait(other), noise)
    return bool(near and found.is_copy), found


def row(what: str, pairs: Iterable[tuple[Picture, Picture]], noise: float) -> None:
    """One line of the table."""
    results = [is_found(one, other, noise) for one, other in pairs]
    ratios = np.array([found.ratio for _, found in results])
    near = np.median(ratios[np.isfinite(ratios)]) if np.isfinite(ratios).any() else np.inf
    print(
        f"{what:<44}{sum(found for found, _ in results):>5} of {len(results):<5}"
        f"   ratio {ratios.min():7.2f} {near:7.2f} {ratios.max():7.2f}"
    )


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="every eighth picture")
    step = 8 if parser.parse_args().quick else 1
    presses, contacts = gelsight()[::step], digit()
    grain = sensor_noise(presses)
    print(f"noise of the GelSight, from its pictures: {grain:.2f} grey levels; a ratio up to {COPY_RATIO} is a copy")
    print(f"{'pairs':<44}{'called copies':<14}   {'least, median, most':>24}")
    for name, change in CHANGES.items():
        row(f"copy, {name} (GelSight)", ((press, change(press)) for press in presses), grain)
        row(f"copy, {name} (DIGIT)", ((contact, change(contact)) for contact in contacts), 1.0)
    row("different presses (GelSight)", itertools.combinations(presses, 2), grain)
    row("different contacts (DIGIT)", [(contacts[0], contacts[1])], 1.0)
    rng = np.random.default_rng(0)
    for quality, noise in itertools.product((0, 95, 85, 75), (0.7, 1.0, 2.0)):
        # what the audit knows is the noise that survives compression, so it is estimated from such pictures
        twice = [recorded_twice(press, noise, quality, rng) for press in (*presses, *contacts)]
        level = sensor_noise([pair[0] for pair in twice[: len(presses)]])
        kept = f"JPEG {quality}" if quality else "lossless"
        row(f"same pose twice, noise {noise}, {kept}", twice, level)
    return 0


if __name__ == "__main__":
    sys.exit(main())
