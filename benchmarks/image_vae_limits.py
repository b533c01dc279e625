"""What an image VAE gives back of a touch, beside a linear model: mean differences inside the contact.

    python benchmarks/image_vae_limits.py RUNS/data/WORLD/ds.zarr NAME=BEST.pt [NAME=BEST.pt ...] [--components 64 256]

The linear model: principal components of picture minus background of the train part. Of the VAEs: encoded and decoded,
and their change (decoded picture minus decoded background) on the recorded background.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sklearn.decomposition import PCA

from split_models.learning.contact_region import contact_region
from split_models.learning.data import TouchFrames
from split_models.networks.image_vae import ImageVae
from split_models.tables.evaluate import of_each_sensor
from split_models.transfer.latent_transfer import Laid, LatentTransfer, load_image_vae
from tactiledata.metrics.image_similarity import IMAGE_SIMILARITY

Pictures = NDArray[np.uint8]
Again = Callable[[Pictures, Pictures], Pictures]
"""Pictures (n, h, w, 3) and their background (h, w, 3) -> the pictures once more."""
PARTS = ("val", "test_unseen")
LEARNED_FROM = 2000
"""Frames of the train part that the linear model has."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("store", type=Path)
    parser.add_argument("models", nargs="+", metavar="NAME=CHECKPOINT")
    parser.add_argument("--components", type=int, nargs="*", default=[64, 256])
    parser.add_argument("--split", default="default")
    given = parser.parse_args()
    vaes = {}
    for entry in given.models:
        name, _, path = entry.partition("=")
        vaes[name] = load_image_vae(Path(path))[0]
    size = next(iter(vaes.values())).size
    parts = {part: TouchFrames(given.store, f"{given.split}/{part}", size=size, mesh=None) for part in PARTS}
    rows: dict[str, Again] = {
        "no contact at all": lambda pictures, background: np.broadcast_to(background, pictures.shape)
    }
    train = TouchFrames(given.store, f"{given.split}/train", size=size, mesh=None)
    for count in given.components:
        rows[f"{count} principal components of picture - background"] = linear_model(train, count)
    for name, vae in vaes.items():
        rows[f"{name}: encoded and decoded"] = through(vae, "")
        rows[f"{name}: its change on the recorded background"] = through(vae, "change")
    print(f"{'mean absolute grey levels inside the contact':60s}" + "".join(f"{part:>13s}" for part in PARTS))
    for title, again in rows.items():
        print(f"{title:60s}" + "".join(f"{error(again, frames):13.2f}" for frames in parts.values()))


def linear_model(train: TouchFrames, count: int) -> Again:
    """Principal components of what touches change in pictures, sensor by sensor."""
    chosen = np.linspace(0, len(train) - 1, min(len(train), LEARNED_FROM)).astype(int)
    backgrounds = np.stack([train.background(sensor) for sensor in train.sensors[chosen]])
    changes = (train.pictures(chosen).astype(np.float32) - backgrounds).reshape(len(chosen), -1)
    model = PCA(count, svd_solver="randomized", random_state=0).fit(changes)

    def again(pictures: Pictures, background: Pictures) -> Pictures:
        change = (pictures.astype(np.float32) - background).reshape(len(pictures), -1)
        found = model.inverse_transform(model.transform(change)).reshape(pictures.shape)
        return np.clip(np.rint(background + found), 0, 255).astype(np.uint8)

    return again


def through(vae: ImageVae, laid: Laid) -> Again:
    """Pictures through the VAE, transferred from their sensor to itself."""
    method = LatentTransfer("", vae, laid)
    return lambda pictures, background: method.transfer(pictures, background, background)


def error(again: Again, frames: TouchFrames) -> float:
    """Mean over frames."""
    values = np.full(len(frames), np.nan)
    for sensor, numbers in of_each_sensor(frames):
        true, background = frames.pictures(numbers), frames.background(sensor)
        region = contact_region(true, background)
        values[numbers] = IMAGE_SIMILARITY.scores["l1"](again(true, background), true, region)
    return float(np.nanmean(values))


if __name__ == "__main__":
    main()
