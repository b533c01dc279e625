"""A sampler whose order can be resumed, and a loader that knows how far training has come. Imports torch."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import torch
from torch.utils.data import DataLoader, Dataset, Sampler

from tactiledata.errors import TactileDataError
from tactiledata.loaders.collate import collate
from tactiledata.loaders.numpy import Item
from tactiledata.loaders.order import Order


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
        dataset: Dataset[Item],
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
        for step, batch in enumerate(_told_plainly(self._loader), 1):
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


def _told_plainly(batches: Iterable[Item]) -> Iterator[Item]:
    """The batches; an error of ours that comes from a worker process is told without the worker's traceback."""
    try:
        yield from batches
    except TactileDataError as error:
        kind = type(error)
        inside, _, told = error.found.rpartition(f"{kind.__module__}.{kind.__qualname__}: ")
        if "Original Traceback" not in inside:
            raise
        raise kind(told.strip()) from None
