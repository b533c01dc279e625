"""The store as a PyTorch dataset; beside it the sampler and the loader of `resumable`, and `collate`."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import torch
from torch.utils.data import Dataset, get_worker_info

from tactiledata.loaders.cache_room import CACHE_BYTES
from tactiledata.loaders.collate import Frames, collate, new_tensor
from tactiledata.loaders.missing import Missing
from tactiledata.loaders.normalise import Normaliser
from tactiledata.loaders.numpy import Item, TactileArrays
from tactiledata.loaders.order import item_number
from tactiledata.loaders.picture_arrays import channels_first
from tactiledata.loaders.resumable import ResumableSampler, TactileLoader
from tactiledata.loaders.selection import LoadReport
from tactiledata.loaders.streams import Unit
from tactiledata.store.read.pictures import default_threads

__all__ = ["ResumableSampler", "TactileDataset", "TactileLoader", "collate"]


class TactileDataset(Dataset[Item]):
    """One part of a split as tensors.

    Pictures are (3, H, W), float32 in [0, 1] or uint8; values are float32, NaN where nothing was recorded; ``frame``
    (row in the store) and ``t_ns`` are int64; ``sensor``, ``indenter`` and ``trajectory`` (uid) are texts. In
    trajectory mode pictures of a camera are (n, 3, H, W), and signals come at their native rate, (m, k), with their
    times under ``<name>_t_ns``.

    Frames whose image was not recorded or does not decode are not items; ``report`` says how many.

    Parameters
    ----------
    location : str or Path
    split : str
        ``"<split>/<part>"``, for example ``"default/train"``. There is no default: without it, `MissingSplit`.
    streams : sequence of str
    unit : "frame" or "trajectory"
    normalise : bool or sequence of str
        By mean and spread of the train part, whatever part this is; see ``normalisers``.
    missing : "warn", "keep" or "drop"
        Items without values of a stream of numbers: warn and keep, keep, or leave out.
    transform : callable, optional
        Item -> item, applied last. It must be importable (no lambda) where workers are spawned.
    image_dtype : "float32" or "uint8"
    image_size : (rows, columns), optional
        A smaller size at which pictures are decoded.
    cache : path, optional
        A folder on a local disk in which decoded pictures are kept, shared by workers and by processes.
    cache_bytes : int
        What all caches of that folder may take.
    allow_leaks : bool
    threads : int, optional
        Threads that decode images; in a worker process one, unless stated.
    storage_options : dict, optional

    See Also
    --------
    tactiledata.loaders.numpy.TactileArrays : the same without torch; its parameters are described in full.
    """

    def __init__(
        self,
        location: str | os.PathLike[str],
        split: str | None = None,
        streams: Sequence[str] | str = ("digit", "wrench"),
        unit: Unit = "frame",
        *,
        normalise: bool | Sequence[str] = False,
        missing: Missing = "warn",
        transform: Callable[[Item], Item] | None = None,
        image_dtype: str = "float32",
        image_size: Sequence[int] | None = None,
        cache: str | os.PathLike[str] | None = None,
        cache_bytes: int = CACHE_BYTES,
        allow_leaks: bool = False,
        threads: int | None = None,
        storage_options: Mapping[str, Any] | None = None,
    ) -> None:
        self.arrays = TactileArrays(
            location,
            split,
            streams,
            unit,
            normalise=normalise,
            missing=missing,
            image_dtype=image_dtype,
            image_size=image_size,
            cache=cache,
            cache_bytes=cache_bytes,
            allow_leaks=allow_leaks,
            threads=threads,
            storage_options=storage_options,
        )
        self.transform = transform
        self._threads = threads

    @property
    def report(self) -> LoadReport:
        """What it holds, and what it leaves out and why."""
        return self.arrays.report

    @property
    def normalisers(self) -> dict[str, Normaliser]:
        """Mean and spread by which streams are scaled, and the way back."""
        return self.arrays.normalisers

    @property
    def fingerprint(self) -> str:
        """A digest that is the same for the same items of the same store."""
        return self.arrays.fingerprint

    def __len__(self) -> int:
        return len(self.arrays)

    def __getitem__(self, number: int) -> Item:
        return self.__getitems__([item_number(number, len(self))])[0]

    def __getitems__(self, numbers: Sequence[int]) -> Sequence[Item]:
        """Items, read from the store in one call; torch's fetcher calls this."""
        if get_worker_info() is not None and self._threads is None:
            self.arrays.threads = 1  # workers are the parallelism; more threads would fight over the cores
        if self.arrays.unit == "trajectory":
            items: Sequence[Item] = [self._tensors(item) for item in self.arrays.read_trajectories(numbers)]
        else:
            items = Frames(self.arrays.read_frames(numbers), self._tensors)
        return [self.transform(item) for item in items] if self.transform else items

    def _tensors(self, item: Item, is_shared: bool = False) -> Item:
        pictures = {stream.name for stream in self.arrays.streams if stream.is_picture}
        tensors: Item = {}
        for name, value in item.items():
            if name in pictures:
                tensors[name] = self._picture(name, value, is_shared)
            else:
                tensors[name] = torch.from_numpy(value) if isinstance(value, np.ndarray) else value
        return tensors

    def _picture(self, name: str, pixels: Any, is_shared: bool) -> torch.Tensor:
        *leading, rows, columns, colours = pixels.shape
        dtype = torch.uint8 if self.arrays.image_dtype == "uint8" else torch.float32
        tensor = new_tensor((*leading, colours, rows, columns), dtype, is_shared)
        channels_first(pixels, tensor.numpy(), self.arrays.threads or default_threads())
        if name in self.normalisers:
            mean, std = (
                torch.tensor(values, dtype=torch.float32)[:, None, None]
                for values in (self.normalisers[name].mean, self.normalisers[name].std)
            )
            tensor.sub_(mean).div_(std)
        return tensor
