"""A GelSight R1.5 drawn from DIGIT meshes: the image VAE learns the real presses, mesh VAE and projection stay.

    python benchmarks/gelsight_fine_tuned.py --pack dataPack.npz --image-vae BEST.pt --mesh-vae BEST.pt
        --projection BEST.pt --store ds.zarr [--part default/test] [--epochs 30] [--out docs/images/gelsight.jpg]

Rows of the picture: DIGIT touches as recorded; as SPLIT draws them from their meshes; the same meshes on the GelSight's
background by the fine-tuned VAE; real presses of the GelSight; what the VAE makes of these. The first column is without
contact. Ripples, which the paper found, are looked for where no touch is: root mean square of the band between 2 and 6
px of the change against the decoded background.
"""

from __future__ import annotations

import argparse
import copy
import tempfile
from pathlib import Path

import cv2
import numpy as np

from split_models.learning.checkpoint import load_checkpoint
from split_models.learning.contact_region import contact_region
from split_models.learning.data import TouchFrames
from split_models.learning.train_options import TrainOptions
from split_models.networks.latent import LatentMeshToImage, decode_pictures, encode_pictures
from split_models.tables.recorded_title import recorded_title
from split_models.transfer.fine_tune import fine_tune
from split_models.transfer.latent_transfer import load_image_vae
from split_models.transfer.picture_size import scaled
from split_models.transfer.transfer_picture import sheet
from tactiledata.ingest.pipeline import ingest
from tactiledata.splits.make import make_split
from tactiledata.store.read.reader import Store

COLUMNS = 5


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("pack", "image-vae", "mesh-vae", "projection", "store"):
        parser.add_argument(f"--{name}", type=Path, required=True)
    parser.add_argument("--part", default="default/test")
    parser.add_argument("--epochs", type=int, default=30)
    parser.add_argument("--out", type=Path, default=Path("docs/images/gelsight.jpg"))
    given = parser.parse_args()
    vae, digest, _ = load_image_vae(given.image_vae)
    tuned = copy.deepcopy(vae)
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch) / "gelsight.zarr"
        ingest([given.pack], place)
        make_split(Store.open(place), by="trajectory", hold_out="none", force=None)
        parts = [TouchFrames(place, f"default/{part}", camera="gelsight_r15") for part in ("train", "val", "test")]
        options = TrainOptions(given.epochs, batch_size=16, learning_rate=3e-4, decay=0.97)
        found = fine_tune(tuned, digest, parts[0], parts[1], options, Path(scratch) / "tuned")
        presses = scaled(np.concatenate([parts[2].pictures([n]) for n in range(len(parts[2]))]), vae.size)
        untouched = scaled(parts[2].background(parts[2].sensor_names[0])[None], vae.size)[0]
    print(
        f"{found.pictures} presses learned from, {given.epochs} epochs; decoded presses of val: {found.before:.1f} grey"
        f" levels off before, {found.after:.1f} after"
    )
    frames = TouchFrames(given.store, given.part, size=vae.size, mesh="", kept_bytes=0)
    mine = np.flatnonzero(frames.sensors == frames.sensor_names[0])
    chosen = mine[np.linspace(0, len(mine) - 1, COLUMNS).astype(int)]
    digit, background = frames.pictures(chosen), frames.background(frames.sensor_names[0])
    mesh_vae, projection = (load_checkpoint(path).network() for path in (given.mesh_vae, given.projection))
    moved = frames.displacements(chosen)
    drawn = LatentMeshToImage("split", mesh_vae, vae, projection).predict(moved, background)
    gelsight = LatentMeshToImage("split", mesh_vae, tuned, projection).predict(moved, untouched)
    shown = presses[np.linspace(0, len(presses) - 1, COLUMNS).astype(int)]
    again = decode_pictures(tuned, encode_pictures(tuned, shown))
    decoded = decode_pictures(tuned, encode_pictures(tuned, untouched[None]))[0]
    print(f"ripples, GelSight drawn from meshes: {ripples(gelsight, decoded, contact_region(digit, background)):.2f}")
    pressed = contact_region(shown, untouched)
    print(f"ripples, decoded presses: {ripples(again, decoded, pressed):.2f}")
    print(f"ripples, real presses: {ripples(shown, untouched, pressed):.2f} (camera noise among them)")
    lines = [
        [("DIGIT", background), *((recorded_title(given.store), one) for one in digit)],
        [("", background), *(("from meshes", one) for one in drawn)],
        [("GelSight", untouched), *(("from the same meshes", one) for one in gelsight)],
        [("GelSight", untouched), *(("real press", one) for one in shown)],
        [("decoded", decoded), *(("decoded", one) for one in again)],
    ]
    picture = sheet(lines)
    small = cv2.resize(picture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(given.out), small[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 90])
    print(f"{given.out}: {given.out.stat().st_size / 1e3:.0f} kB")


def ripples(pictures: np.ndarray, untouched: np.ndarray, touched: np.ndarray) -> float:
    """Grey levels, root mean square, of the band between 2 and 6 px where nothing touches."""
    found = []
    for picture, mask in zip(pictures, touched, strict=True):
        change = picture.astype(np.float32) - untouched
        band = cv2.GaussianBlur(change, (0, 0), 2) - cv2.GaussianBlur(change, (0, 0), 6)
        away = cv2.dilate(mask.astype(np.uint8), np.ones((13, 13), np.uint8)) == 0
        found.append(np.square(band[away]).mean())
    return float(np.sqrt(np.mean(found)))


if __name__ == "__main__":
    main()
