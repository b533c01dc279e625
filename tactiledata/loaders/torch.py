"""The store as a PyTorch dataset, a sampler that resumes, and a loader that puts them together."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import torch
from torch.utils.data import DataLoader, Dataset, Sampler, get_worker_info

from tactiledata.loaders.collate import Frames, collate
from tactiledata.loaders.missing import Missing
from tactiledata.loaders.normalise import Normaliser
from tactiledata.loaders.numpy import Item, TactileArrays
from tactiledata.loaders.order import Order
from tactiledata.loaders.selection import LoadReport
from tactiledata.loaders.streams import Unit

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
        """The same for the same items of the same store."""
        return self.arrays.fingerprint

    def __len__(self) -> int:
        return len(self.arrays)

    def __getitem__(self, number: int) -> Item:
        if not -len(self) <= number < len(self):
            raise IndexError(f"item {number} of {len(self)}")
        return self.__getitems__([number % len(self)])[0]

    def __getitems__(self, numbers: Sequence[int]) -> list[Item]:
        """Items, read from the store in one call; torch's fetcher calls this."""
        if get_worker_info() is not None and self._threads is None:
            self.arrays.threads = 1  # workers are the parallelism; more threads would fight over the cores
        if self.arrays.unit == "trajectory":
            items = [self._tensors(item) for item in self.arrays.read_trajectories(numbers)]
            return [self.transform(item) for item in items] if self.transform else items
        batch = self._tensors(self.arrays.read_frames(numbers))
        items = [{name: value[place] for name, value in batch.items()} for place in range(len(numbers))]
        return [self.transform(item) for item in items] if self.transform else Frames(items, batch)

    def _tensors(self, item: Item) -> Item:
        pictures = {stream.name for stream in self.arrays.streams if stream.is_picture}
        tensors: Item = {}
        for name, value in item.items():
            if name in pictures:
                tensors[name] = self._picture(name, value)
            else:
                tensors[name] = torch.from_numpy(value) if isinstance(value, np.ndarray) else value
        return tensors

    def _picture(self, name: str, pixels: Any) -> torch.Tensor:
        tensor = torch.from_numpy(pixels).movedim(-1, -3).contiguous()
        if self.arrays.image_dtype == "uint8":
            return tensor
        scaled = tensor.to(torch.float32).div_(255)
        if name in self.normalisers:
            mean, std = (
                torch.tensor(values, dtype=torch.float32)[:, None, None]
                for values in (self.normalisers[name].mean, self.normalisers[name].std)
            )
            scaled.sub_(mean).div_(std)
        return scaled


class ResumableSampler(Sampler[Any]):
    """The order of a dataset's items: seeded, parted between ranks, resumable.

    Iterating goes on from the present state to the end of the epoch. Interrupted and resumed, it gives what it would
    have given uninterrupted; the state is the same on every rank and may be resumed by another number of ranks.

    A `DataLoader` with workers asks for items ahead of the training step, so that the sampler's own state is ahead,
    too: use `TactileLoader`, which counts the batches that were handed out.

    Parameters
    ----------
    dataset : TactileDataset, or anything with a length
    seed : int
    shuffle : bool
    batch_size : int, optional
        Give lists of item numbers, for ``DataLoader(batch_sampler=...)``; else single numbers, for ``sampler=``.
    rank, world_size : int, optional
        By default those of ``torch.distributed`` where it is initialised, else 0 of 1.
    drop_last : bool, optional
        Leave out the tail that does not give every rank a full step. Default: only where there are several ranks.
    """

    def __init__(
        self,
        dataset: Any,
        seed: int = 0,
        shuffle: bool = True,
        batch_size: int | None = None,
        rank: int | None = None,
        world_size: int | None = None,
        drop_last: bool | None = None,
    ) -> None:
        is_parallel = torch.distributed.is_available() and torch.distributed.is_initialized()
        self.order = Order(
            len(dataset),
            seed=seed,
            shuffle=shuffle,
            batch_size=batch_size,
            rank=rank if rank is not None else torch.distributed.get_rank() if is_parallel else 0,
            world_size=world_size
            if world_size is not None
            else torch.distributed.get_world_size()
            if is_parallel
            else 1,
            drop_last=drop_last,
            fingerprint=getattr(dataset, "fingerprint", ""),
        )

    def __iter__(self) -> Iterator[Any]:
        return iter(self.order)

    def __len__(self) -> int:
        return len(self.order)

    def set_epoch(self, epoch: int) -> None:
        """Go to the start of an epoch."""
        self.order.set_epoch(epoch)

    def state_dict(self) -> dict[str, Any]:
        """The state as JSON values; see `Order.state_dict`."""
        return self.order.state_dict()

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Go on where a state was taken; see `Order.load_state_dict`."""
        self.order.load_state_dict(state)


class TactileLoader:
    """Batches of a dataset, by a `DataLoader` whose state counts what was handed out, not what workers fetched ahead.

    Iterating goes on from the present state to the end of the epoch; the next iteration is the next epoch.

    Parameters
    ----------
    dataset : TactileDataset
    batch_size : int
    seed, shuffle, rank, world_size, drop_last
        As for `ResumableSampler`.
    **options
        For `DataLoader`: ``num_workers``, ``pin_memory``, ``multiprocessing_context``, ``persistent_workers`` …

    Examples
    --------
    A training loop that can be killed::

        loader = TactileLoader(train, batch_size=64, seed=1, num_workers=2)
        loader.load_state_dict(checkpoint["loader"])
        for epoch in range(loader.epoch, n_epochs):
            for batch in loader:
                ...
                checkpoint["loader"] = loader.state_dict()
    """

    def __init__(
        self,
        dataset: TactileDataset,
        batch_size: int,
        *,
        seed: int = 0,
        shuffle: bool = True,
        rank: int | None = None,
        world_size: int | None = None,
        drop_last: bool | None = None,
        **options: Any,
    ) -> None:
        self.sampler = ResumableSampler(dataset, seed, shuffle, batch_size, rank, world_size, drop_last)
        self._loader: DataLoader[Item] = DataLoader(
            dataset, **{"collate_fn": collate, **options, "batch_sampler": self.sampler}
        )
        self._position = (0, 0)

    @property
    def epoch(self) -> int:
        """The epoch that the next batch belongs to."""
        return self._position[0]

    def __len__(self) -> int:
        """Batches of this rank from the present state to the end of the epoch."""
        self.sampler.order.seek(*self._position)
        return len(self.sampler)

    def __iter__(self) -> Iterator[Item]:
        order = self.sampler.order
        order.seek(*self._position)
        epoch, start = self._position
        for step, batch in enumerate(self._loader, 1):
            self._position = (epoch, min(order.length, start + step * order.stride))
            yield batch
        self._position = (epoch + 1, 0)

    def set_epoch(self, epoch: int) -> None:
        """Go to the start of an epoch."""
        self._position = (epoch, 0)

    def state_dict(self) -> dict[str, Any]:
        """The state as JSON values: the batches handed out so far are behind it."""
        epoch, consumed = self._position
        return {**self.sampler.state_dict(), "epoch": epoch, "consumed": consumed}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Go on where a state was taken.

        Raises
        ------
        UsageError
            It belongs to another dataset, split, part or seed.
        """
        self.sampler.load_state_dict(state)
        self._position = (self.sampler.order.epoch, self.sampler.order.consumed)
