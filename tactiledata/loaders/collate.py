"""Items put together into batches: frames stacked, trajectories padded. Imports torch; use it by `loaders.torch`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import torch
from torch.utils.data import default_collate

from tactiledata.loaders.numpy import TIMES, Item

FRAME_GROUP = "frames"
"""Under this name `collate` says how many frames each trajectory has, and which of the padded ones are frames."""


class Frames(list[Item]):
    """Items of frames that were read together, with the batch that they are views of: `collate` need not copy."""

    def __init__(self, items: Sequence[Item], batch: Item) -> None:
        super().__init__(items)
        self.batch = batch


def collate(items: Sequence[Item]) -> Item:
    """A batch of items of either mode.

    Frames are stacked. Trajectories are padded with zeros to the longest: entries that go by frames share
    ``frames_lengths`` (b,) and ``frames_mask`` (b, n), each native-rate signal has ``<name>_lengths`` and
    ``<name>_mask``. A mask is True where something was recorded, and False in the padding.
    """
    if isinstance(items, Frames):
        return items.batch
    first = items[0]
    if "in_split" not in first:
        return default_collate(list(items))
    signals = [name.removesuffix(TIMES) for name in first if name.endswith(TIMES) and name.removesuffix(TIMES) in first]
    lengths = {
        FRAME_GROUP: [len(item["frame"]) for item in items],
        **{signal: [len(item[signal]) for item in items] for signal in signals},
    }
    batch: Item = {name: _together(name, [item[name] for item in items], lengths) for name in first}
    for group, counts in lengths.items():
        batch[f"{group}_lengths"] = torch.tensor(counts)
        batch[f"{group}_mask"] = torch.arange(max(counts))[None, :] < batch[f"{group}_lengths"][:, None]
    return batch


def _together(name: str, values: list[Any], lengths: Mapping[str, list[int]]) -> Any:
    if not isinstance(values[0], torch.Tensor):
        return values
    counts = [len(value) if value.ndim else -1 for value in values]
    # what is as long as its item has frames goes by frames; where all lengths are equal, padding is stacking anyway
    if counts in (lengths[FRAME_GROUP], lengths.get(name), lengths.get(name.removesuffix(TIMES))):
        return torch.nn.utils.rnn.pad_sequence(values, batch_first=True)
    return torch.stack(values)
