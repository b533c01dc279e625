"""Items put together into batches: frames stacked, trajectories padded. Imports torch; use it by `loaders.torch`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import torch
from torch.utils.data import default_collate, get_worker_info

from tactiledata.loaders.numpy import TIMES, Item

FRAME_GROUP = "frames"
"""Under this name `collate` says how many frames each trajectory has, and which of the padded ones are frames."""


class Frames(Sequence[Item]):
    """Items of frames that were read together: tensors are made as a batch for `collate`, else item by item.

    Parameters
    ----------
    read : Item
        Arrays and lists with the frames along their first axis.
    tensors : callable
        (such an item, whether its pictures are to lie in shared memory) -> the same as tensors.
    """

    def __init__(self, read: Item, tensors: Callable[[Item, bool], Item]) -> None:
        self._read, self._tensors = read, tensors
        self._items: list[Item] = []

    def __len__(self) -> int:
        return len(self._read["frame"])

    def __getitem__(self, place: Any) -> Any:
        if not self._items:
            parts = (
                {name: value[start : start + 1] for name, value in self._read.items()} for start in range(len(self))
            )
            alone = (self._tensors(part, False) for part in parts)
            self._items = [{name: value[0] for name, value in item.items()} for item in alone]
        return self._items[place]

    def batch(self) -> Item:
        """All of them stacked; in a worker in memory that the main process sees, so that nothing is copied."""
        return self._tensors(self._read, get_worker_info() is not None)


def new_tensor(shape: Sequence[int], dtype: torch.dtype, is_shared: bool) -> torch.Tensor:
    """An empty tensor, in memory that can be handed to another process, or in large pages of this one.

    Parameters
    ----------
    shape : sequence of int
    dtype : torch.dtype
    is_shared : bool
        Whether another process is to get it. torch copies what does not lie in shared memory.
    """
    empty = torch.empty(0, dtype=dtype)
    if is_shared:  # as torch's own collate does
        storage = torch.UntypedStorage._new_shared(math.prod(shape) * empty.element_size(), device="cpu")
        return empty.set_(storage).view(*shape)
    # numpy asks the system for large pages, torch does not: touching them first takes a third of the time
    return torch.from_numpy(np.empty(shape, empty.numpy().dtype))


def collate(items: Sequence[Item]) -> Item:
    """A batch of items of either mode.

    Frames are stacked. Trajectories are padded with zeros to the longest: entries that go by frames share
    ``frames_lengths`` (b,) and ``frames_mask`` (b, n), each native-rate signal has ``<name>_lengths`` and
    ``<name>_mask``. A mask is True where something was recorded, and False in the padding.
    """
    if isinstance(items, Frames):
        return items.batch()
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
