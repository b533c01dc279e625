"""Real contacts on real backgrounds by every method: how much of the touch is kept, in tables, and a picture.

    python benchmarks/transfer_real_contacts.py [--model CHECKPOINT] [--presses 6] [--style] [--json FILE]
        [--out docs/images/transfer-real-contacts.jpg]

Contacts are two of a DIGIT (AUROVA-LAB) and presses of a GelSight R1.5 (ObjectFolder), which are rotated and scaled to
a DIGIT's picture. Nothing was trained on them. The rule of `relit` was chosen on the GelSight presses of even number,
on the second DIGIT contact and on the backgrounds `CHOSEN_ON`; the tables show presses of odd number and the first
DIGIT contact on the other backgrounds. Cells are medians over contacts and backgrounds, with the 10 % and 90 %
quantiles. A last table says in which share of the cases `relit`, which a user gets by default, meets each of `ASKED`.

The DIGIT contacts' authors published no picture of their sensor without contact. It is filled in here: what their mask
of the first contact covers, widened, from its surroundings. What is inside is a guess, and the same for both contacts.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from split_models.transfer.methods import LATENT, TransferMethod, transfer_method
from split_models.transfer.picture_size import scaled
from split_models.transfer.pixels import PIXEL_TRANSFERS
from tactiledata.contract.atomic import write_json_atomic
from tactiledata.metrics.gram_style import GRAM_STYLE
from tactiledata.metrics.kept_touch import KEPT_TOUCH, change_of, touched
from tactiledata.sensors.backgrounds import bundled_backgrounds, load_background

CHOSEN_ON = ("digit-bg-0", "digit-bg-2", "digit-bg-4", "digit-bg-9", "digit-bg-13")
"""Backgrounds on which the rule of `relit` was chosen."""
UNSEEN = ("digit-bg-1", "digit-bg-16")
"""Backgrounds on which neither the rule was chosen nor the bundled model trained."""
SHOWN = ("ycb-sensorA", "ycb-sensorB", "digit-bg-6", "digit-bg-9", "digit-bg-16")
SHOWN_METHODS = (
    "relit",
    "latent_relit",
    "latent_on_background",
    "latent",
    "background_swap",
    "background_ratio",
    "histogram_matching",
    "reinhard",
    "fourier",
)
CONTACTS = ("digit_raw", "limitation_raw_digit")
SIZE = (320, 240)
SCALE = 0.34
GAP = 3
COLUMNS = (*KEPT_TOUCH.scores, "outside", "style")
ASKED: dict[str, tuple[Callable[[dict[str, Any]], float], Callable[[dict[str, Any]], str]]] = {
    "strength kept 0.85 to 1.15": (
        lambda case: 0.15 - abs(case["strength_kept"] - 1.0),
        lambda case: f"{case['strength_kept']:.3f}",
    ),
    "correlation at least 0.9": (
        lambda case: case["change_correlation"] - 0.9,
        lambda case: f"{case['change_correlation']:.3f}",
    ),
    "mask overlap at least 0.75": (
        lambda case: case["mask_overlap"] - 0.75,
        lambda case: f"{case['mask_overlap']:.3f}",
    ),
    "error outside at most the swap's and one grey level": (
        lambda case: case["outside_of_swap"] + 1.0 - case["outside"],
        lambda case: f"{case['outside']:.2f} to {case['outside_of_swap']:.2f}",
    ),
    "style no worse than the swap's": (
        lambda case: case["style_of_swap"] - case["style"],
        lambda case: f"{case['style']:.3g} to {case['style_of_swap']:.3g}",
    ),
}
"""What is asked of the default: by how much a case meets it, below 0 where it does not, and the case in words."""

Contacts = tuple[np.ndarray, np.ndarray]
"""Pictures (n, H, W, 3) of one sensor, and the same sensor (H, W, 3) without contact."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--contacts", type=Path, default=Path("tests/data/digit_contact"))
    parser.add_argument("--pack", type=Path, default=Path("tests/data/gelsight_r15/dataPack.npz"))
    parser.add_argument("--model", type=Path, help="an image VAE [default: the bundled one]")
    parser.add_argument("--presses", type=int, default=6, help="number of GelSight presses in the tables")
    parser.add_argument(
        "--style",
        action="store_true",
        help="the style distance outside the contact as well, on backgrounds that the model never saw",
    )
    parser.add_argument("--json", type=Path, help="file that takes the tables as a document")
    parser.add_argument("--out", type=Path, default=Path("docs/images/transfer-real-contacts.jpg"))
    given = parser.parse_args()
    methods = [transfer_method(name, given.model) for name in LATENT]
    methods += [transfer_method(name) for name in PIXEL_TRANSFERS]
    digit, background = digit_contacts(given.contacts)
    presses, untouched = gelsight_presses(given.pack)
    odd = presses[1::2]
    sets = {
        "first DIGIT contact": (digit[:1], background),
        "GelSight presses": (odd[np.linspace(0, len(odd) - 1, given.presses).astype(int)], untouched),
    }
    rows, kept = [], []
    others = [name for name in bundled_backgrounds() if name not in CHOSEN_ON]
    for title, contacts in sets.items():
        for words, targets in ((f"{len(others)} backgrounds", others), ("2 that the model never saw", UNSEEN)):
            print(f"\n{title} ({len(contacts[0])}) on {words}")
            has_style = given.style and targets == UNSEEN
            rows += [{"contacts": title, "on": words, **row} for row in table(methods, contacts, targets, has_style)]
        kept += [{"contacts": title, **row} for row in asked(contacts, others)]
    shares(kept)
    if given.json:
        write_json_atomic(given.json, {"format": "tactiledata-figures/1", "rows": rows, "asked": kept})
    shown = [(f"contact {n + 1}", digit[n], background) for n in range(len(digit))]
    draw([*shown, ("GelSight press", odd[len(odd) // 2], untouched)], methods, given.out)


def digit_contacts(folder: Path) -> Contacts:
    """The two real contacts of a DIGIT, and its picture without contact as far as it can be filled in."""
    pictures = np.stack([read(folder / f"{name}.png") for name in CONTACTS])
    return pictures, filled_in(pictures[0], folder / "digit_mask.png")


def gelsight_presses(pack: Path) -> Contacts:
    """The real presses of a GelSight R1.5 and its picture without contact, in the size of a DIGIT's pictures."""
    with np.load(pack) as held:
        pictures, untouched = (np.ascontiguousarray(held[name][..., ::-1], np.uint8) for name in ("imgs", "f0"))
    return scaled(pictures, SIZE), scaled(untouched[None], SIZE)[0]


def table(
    methods: list[TransferMethod], contacts: Contacts, targets: tuple[str, ...] | list[str], style: bool
) -> list[dict[str, Any]]:
    """Print a row for each method: medians over contacts and targets, with quantiles; the same as values."""
    rows = []
    columns = COLUMNS if style else COLUMNS[:-1]
    print(f"| method | {' | '.join(columns)} |\n|---|{'---|' * len(columns)}")
    for method in methods:
        found = np.concatenate([values(method, contacts, load_background(name), style) for name in targets], axis=1)
        cells = []
        row: dict[str, Any] = {"method": method.name}
        for name, column in zip(columns, found, strict=True):
            low, middle, high = np.nanquantile(column, (0.1, 0.5, 0.9))
            row[name] = {"median": float(middle), "low": float(low), "high": float(high)}
            cells.append(f"{middle:.3g} [{low:.3g}, {high:.3g}]")
        print(f"| `{method.name.replace('_', '-')}` | {' | '.join(cells)} |", flush=True)
        rows.append(row)
    return rows


def asked(contacts: Contacts, targets: list[str]) -> list[dict[str, Any]]:
    """Scores of `relit` on each target, one dict for each contact, with the swap's error outside the contact."""
    cases = []
    for target in targets:
        ours = values(transfer_method("relit"), contacts, load_background(target), style=True)
        swap = values(transfer_method("background_swap"), contacts, load_background(target), style=True)
        for number in range(ours.shape[1]):
            scored = dict(zip(COLUMNS, map(float, ours[:, number]), strict=True))
            against = {f"{name}_of_swap": float(swap[COLUMNS.index(name), number]) for name in ("outside", "style")}
            cases.append({"target": target, "contact": number, **scored, **against})
    return cases


def shares(cases: list[dict[str, Any]]) -> None:
    """Print in which share of the cases each demand is met, and how far the worst case is."""
    print("\n| `relit`, of all cases | met in | worst |\n|---|---|---|")
    for contacts in dict.fromkeys(case["contacts"] for case in cases):
        own = [case for case in cases if case["contacts"] == contacts]
        for words, (margin, shown) in ASKED.items():
            margins = np.array([margin(case) for case in own])
            worst = own[int(np.argmin(margins))]
            print(f"| {contacts}: {words} | {(margins >= 0).sum()} of {len(own)} | {shown(worst)} |")


def values(method: TransferMethod, contacts: Contacts, target: np.ndarray, style: bool) -> np.ndarray:
    """Scores (columns, n) of a method on one target."""
    pictures, background = contacts
    moved = method.transfer(pictures, background, target)
    ours, theirs = change_of(moved, target), change_of(pictures, background)
    rows = [score(ours, theirs) for score in KEPT_TOUCH.scores.values()]
    away = ~touched(theirs)
    rows.append(np.array([np.abs(change)[mask].mean() for change, mask in zip(ours, away, strict=True)]))
    if style:
        # each picture beside the target under the same mask: another press's mask is another piece of the target
        distance = GRAM_STYLE.scores["gram_style_random"].compute
        pairs = zip(moved[:, None], away[:, None], strict=True)
        rows.append(np.concatenate([distance(one, target[None], mask, mask) for one, mask in pairs]))
    return np.stack(rows)


def draw(contacts: list[tuple[str, np.ndarray, np.ndarray]], methods: list[TransferMethod], out: Path) -> None:
    """Write the picture: a row for each contact and method, a column for each target."""
    by_name = {method.name: method for method in methods}
    targets = [load_background(name) for name in SHOWN]
    rows = []
    for title, touch, background in contacts:
        rows.append(line(f"{title}: without contact", [background, *targets]))
        for name in SHOWN_METHODS:
            cells = [touch, *(by_name[name].transfer(touch[None], background, target)[0] for target in targets)]
            rows.append(line(f"{title}, {name.replace('_', ' ')}", cells))
    out.parent.mkdir(parents=True, exist_ok=True)
    columns = len(contacts)
    each = len(rows) // columns
    sheet = np.hstack([np.vstack(rows[number * each : (number + 1) * each]) for number in range(columns)])
    cv2.imwrite(str(out), sheet[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])
    print(f"{out}: {out.stat().st_size / 1e3:.0f} kB")


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
