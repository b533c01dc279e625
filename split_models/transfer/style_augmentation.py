"""Transfer as augmentation: some pictures of a training batch get the style of other sensors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray

from split_models.learning.held_out_background import refuse_held_out
from split_models.transfer.methods import TransferMethod, transfer_method
from tactiledata.errors import StoreError, UsageError
from tactiledata.loaders.numpy import Item, TactileArrays
from tactiledata.loaders.torch import TactileDataset
from tactiledata.splits.manifest import read_split
from tactiledata.store.read.targets import find_target

OWN = ""
"""Value under ``style`` of pictures that are not transferred."""
DEFAULT_METHOD = "background_ratio"
"""Name of the transfer method that is used unless another is given."""


class StyleAugmentation:
    """A function of batches that transfers a share of their pictures to other sensors.

    Seed, epoch and frame alone decide which pictures are transferred, and to which sensor; neither the order of frames
    nor the number of workers matters. ``style`` of the batch names the target of each picture; ``sensor`` stays the
    source.

    Parameters
    ----------
    dataset : TactileDataset
        Dataset of the train part, in frame mode, whose pictures are not normalised.
    targets : sequence of str
        Sensors of the store or bundled backgrounds, as `tactiledata transfer --to` takes them.
    method : TransferMethod, optional
        Transfer method; the ratio of backgrounds unless given.
    share : float
        Share of the pictures that is transferred.
    seed : int
        Seed of the choices.

    Raises
    ------
    UsageError
        A target is held out of the train part, or has another size than the pictures; the dataset is of another part,
        of trajectories, or without plain pictures; the share is beyond [0, 1].
    UnknownName
        A target does not exist.
    StoreError
        A sensor of the dataset has no picture without contact.
    """

    def __init__(
        self,
        dataset: TactileDataset,
        targets: Sequence[str],
        method: TransferMethod | None = None,
        share: float = 0.5,
        seed: int = 0,
    ) -> None:
        arrays = dataset.arrays
        self.camera = _camera(arrays)
        if not 0.0 <= share <= 1.0 or not targets:
            raise UsageError(f"a share of {share} moved to {len(targets)} targets", "0 to 1, and at least one", "")
        self.method = method or transfer_method(DEFAULT_METHOD)
        self.share, self.seed = share, seed
        store, known = arrays.store, _train_sensors(arrays)
        own = arrays.index.sensor_names
        if lacking := [name for name in own if name not in store.manifest["references"]]:
            raise StoreError(
                f"{', '.join(lacking)} without a picture without contact",
                "a background for every sensor that is transferred",
                f"`tactiledata sensors add {lacking[0]} --background FILE...`",
            )
        self._own = {name: store.reference(name).image for name in own}
        self._targets = {name: find_target(name, store).background for name in targets}
        size = next(iter(self._own.values())).shape
        for name, picture in self._targets.items():
            if picture.shape != size:
                raise UsageError(f"the background of {name} has shape {picture.shape}", f"that of the pictures, {size}")
            refuse_held_out(name, picture, store, known, "Leave it out of the targets.")

    def __call__(self, batch: Item, epoch: int = 0) -> Item:
        """The batch with new pictures (n, 3, H, W) of the same type, and ``style``; the given batch is not changed."""
        pictures = batch[self.camera].clone()
        styles = [self._drawn(int(frame), epoch) for frame in batch["frame"]]
        groups: dict[tuple[str, str], list[int]] = {}
        for row, style in enumerate(styles):
            if style != OWN:
                groups.setdefault((batch["sensor"][row], style), []).append(row)
        for (sensor, style), rows in groups.items():
            moved = self.method.transfer(_as_bytes(pictures[rows]), self._own[sensor], self._targets[style])
            pictures[rows] = _as_tensor(moved, pictures.dtype)
        return {**batch, self.camera: pictures, "style": styles}

    def _drawn(self, frame: int, epoch: int) -> str:
        """Target of a frame in an epoch, or `OWN`."""
        rng = np.random.default_rng([self.seed, epoch, frame])
        return list(self._targets)[rng.integers(len(self._targets))] if rng.random() < self.share else OWN


def _camera(arrays: TactileArrays) -> str:
    """Name of the dataset's stream of pictures; datasets of trajectories and of normalised pictures are refused."""
    cameras = [stream.name for stream in arrays.streams if stream.kind == "image"]
    if arrays.unit != "frame" or not cameras or cameras[0] in arrays.normalisers:
        content = "trajectories" if arrays.unit != "frame" else "normalised pictures" if cameras else "no pictures"
        raise UsageError(
            f"a dataset of {content}", "frames with pictures that are not normalised", "Normalise them after it."
        )
    return cameras[0]


def _train_sensors(arrays: TactileArrays) -> set[str]:
    """Sensors with a trajectory in the train part of the dataset's split; a dataset of another part is refused."""
    split, _, part = arrays.report.split.partition("/")
    if part != "train":
        raise UsageError(
            f"augmentation of {arrays.report.split}", "a train part; test pictures stay as they were recorded", ""
        )
    trained = read_split(arrays.store, split).table
    uids = {row["uid"] for row in trained.to_pylist() if row["partition"] == "train"}
    table = arrays.store.trajectories(["uid", "sensor"])
    pairs = zip(table["uid"].to_pylist(), table["sensor"].to_pylist(), strict=True)
    return {str(sensor) for uid, sensor in pairs if uid in uids}


def _as_bytes(pictures: torch.Tensor) -> NDArray[np.uint8]:
    """Pictures (n, H, W, 3), uint8, from a tensor (n, 3, H, W) of uint8 or of floats in [0, 1]."""
    last = pictures.movedim(1, -1)
    return np.ascontiguousarray((last if last.dtype == torch.uint8 else (last * 255).round().byte()).numpy())


def _as_tensor(pictures: NDArray[np.uint8], dtype: torch.dtype) -> torch.Tensor:
    """A tensor (n, 3, H, W) of a type, floats in [0, 1], from pictures (n, H, W, 3), uint8."""
    first = torch.from_numpy(pictures).movedim(-1, 1)
    return first if dtype == torch.uint8 else first.to(dtype) / 255
