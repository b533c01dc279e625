"""The program with which somebody starts to use a store: made of the streams and the split that it has."""

from __future__ import annotations

import json

import numpy as np
import pyarrow.compute as pc

from tactiledata.splits.manifest import read_split_document
from tactiledata.splits.options import PARTITIONS
from tactiledata.splits.suggest import suggest_split
from tactiledata.store.read.reader import Store

NUMBERS = ("contact_wrench", "wrench", "tcp", "joints")
"""Values at the moments of frames, the most wanted first."""


def first_program(store: Store, split: str) -> str:
    """A program that reads a store: batches of a part of a split, or tables where no split can be drawn."""
    part = _part(store, split)
    if not part:
        return (
            "from tactiledata.store.read.reader import Store\n\n"
            f"store = Store.open({_text(store.location)})\n"
            "print(store.trajectories().to_pandas())"
        )
    return (
        "from torch.utils.data import DataLoader\n"
        "from tactiledata.loaders.torch import TactileDataset\n\n"
        f'{part} = TactileDataset({_text(store.location)}, split="{split}/{part}", streams={_text(_streams(store))})\n'
        f"for batch in DataLoader({part}, batch_size=64, num_workers=2):\n"
        "    ..."
    )


def _text(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)


def _part(store: Store, split: str) -> str:
    """The first part of a split that has frames, of that which is there or of that which would be drawn."""
    document = read_split_document(store, split) if split in store.split_names() else None
    if document is not None:
        counts = {part: document["counts"][part]["frames"] for part in PARTITIONS}
    else:
        report = suggest_split(store).report
        counts = {} if report is None else {part: report.counts[part].frames for part in PARTITIONS}
    return next((part for part in PARTITIONS if counts.get(part)), "")


def _streams(store: Store) -> list[str]:
    """The camera with the most images, and the most wanted values that there are."""
    counted = pc.value_counts(store.frames(["camera"])["camera"]).to_pylist()
    camera = max(counted, key=lambda entry: entry["counts"])["values"]
    there = [name for name in (*NUMBERS, *store.aligned_names) if name in store.aligned_names]
    values = [name for name in there if np.isfinite(store.aligned(name)[0]).any()] or list(store.frame_value_names)
    return [camera, *values[:1]]
