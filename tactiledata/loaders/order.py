"""The order in which items are visited: seeded, shared between ranks without overlap, and resumable."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Mapping
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UsageError

STATE_FORMAT = "tactiledata-order/1"


class Order:
    """Item numbers (or lists of them, with ``batch_size``) for one rank, epoch after epoch.

    Iterating goes on from the present state to the end of the epoch, then the epoch number grows: an interrupted walk
    that is resumed from its state visits what the uninterrupted one would have visited. All ranks share one permutation
    and each takes every ``world_size``-th item of it, so that no item is visited by two ranks.

    Parameters
    ----------
    length : int
        Number of items.
    seed : int
        The same seed gives the same order, epoch by epoch.
    shuffle : bool
    batch_size : int, optional
        Yield lists of this many numbers instead of single numbers.
    rank, world_size : int
        Which of how many processes this is.
    drop_last : bool, optional
        Leave out the tail that does not give every rank a full step. Default: only where there are several ranks, since
        ranks with unequal numbers of steps wait for each other for ever.
    fingerprint : str
        Names the items; a state is refused where it belongs to others.

    Examples
    --------
    >>> order = Order(5, seed=0, shuffle=False, batch_size=2)
    >>> steps = iter(order)
    >>> next(steps)
    [0, 1]
    >>> state = order.state_dict()
    >>> resumed = Order(5, seed=0, shuffle=False, batch_size=2)
    >>> resumed.load_state_dict(state)
    >>> list(resumed)
    [[2, 3], [4]]
    """

    def __init__(
        self,
        length: int,
        *,
        seed: int = 0,
        shuffle: bool = True,
        batch_size: int | None = None,
        rank: int = 0,
        world_size: int = 1,
        drop_last: bool | None = None,
        fingerprint: str = "",
    ) -> None:
        _check(length, seed, batch_size, rank, world_size)
        self.length = length
        self.seed = seed
        self.shuffle = shuffle
        self.batch_size = batch_size
        self.rank = rank
        self.world_size = world_size
        self.drop_last = world_size > 1 if drop_last is None else drop_last
        if self.drop_last and 0 < length < self.stride:
            raise UsageError(
                f"{length} items do not give {world_size} ranks a step of {batch_size or 1} each: every epoch is empty",
                f"at least {self.stride} items, since incomplete steps are left out",
                "Take smaller batches or fewer ranks, or say drop_last=False.",
                length=length,
            )
        self.fingerprint = fingerprint
        self.epoch = 0
        self.consumed = 0
        """Items of this epoch that all ranks together have visited."""

    @property
    def stride(self) -> int:
        """Items that all ranks together visit in one step."""
        return (self.batch_size or 1) * self.world_size

    def permutation(self, epoch: int) -> NDArray[np.int64]:
        """All item numbers in the order of an epoch, before ranks part them."""
        if not self.shuffle:
            return np.arange(self.length, dtype=np.int64)
        return np.random.default_rng([self.seed, epoch]).permutation(self.length).astype(np.int64)

    def __len__(self) -> int:
        """Steps of this rank from the present state to the end of the epoch."""
        return self._steps(self.length - self.consumed)

    def _steps(self, remaining: int) -> int:
        if self.drop_last:
            return remaining // self.stride
        mine = max(0, -(-(remaining - self.rank) // self.world_size))
        return -(-mine // (self.batch_size or 1))

    def __iter__(self) -> Iterator[Any]:
        epoch, start = self.epoch, self.consumed
        mine = self.permutation(epoch)[start:][self.rank :: self.world_size]
        size = self.batch_size or 1
        for step in range(self._steps(self.length - start)):
            # counted before it is handed out: a state taken while the step is worked on counts it as visited
            self.epoch, self.consumed = epoch, min(self.length, start + (step + 1) * self.stride)
            numbers = mine[step * size : (step + 1) * size].tolist()
            yield numbers if self.batch_size else numbers[0]
        self.set_epoch(epoch + 1)

    def set_epoch(self, epoch: int) -> None:
        """Go to the start of an epoch."""
        self.epoch, self.consumed = epoch, 0

    def seek(self, epoch: int, consumed: int) -> None:
        """Go to the state in which all ranks together have visited ``consumed`` items of an epoch."""
        self.epoch, self.consumed = epoch, min(self.length, consumed)

    def state_dict(self) -> dict[str, Any]:
        """The state as JSON values, the same on every rank."""
        return {
            "format": STATE_FORMAT,
            "seed": self.seed,
            "shuffle": self.shuffle,
            "length": self.length,
            "fingerprint": self.fingerprint,
            "epoch": self.epoch,
            "consumed": self.consumed,
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Go on where a state was taken; the number of ranks and the batch size may differ.

        Raises
        ------
        UsageError
            The state is of another order: other items, another seed, shuffled or not.
        """
        if not isinstance(state, Mapping):
            raise UsageError(f"the state is {state!r:.80}", "what `state_dict` gave")
        expected = {**self.state_dict(), "epoch": None, "consumed": None}
        differing = [name for name in expected if name not in state] + [
            name for name, value in expected.items() if value is not None and state.get(name, value) != value
        ]
        positions = [state.get("epoch"), state.get("consumed")]
        if differing:
            raise UsageError(
                f"the state does not belong to this order: {', '.join(differing)} differs "
                f"({ {name: state.get(name) for name in differing} })",
                f"{ {name: expected[name] for name in differing} }",
                "Use the state with the dataset, split and seed that it was taken with.",
                differing=differing,
            )
        if not all(_is_count(value) for value in positions) or state["consumed"] > self.length:
            raise UsageError(
                f"the state is at epoch {positions[0]!r}, item {positions[1]!r}",
                f"counts, and at most {self.length} items consumed",
                "The checkpoint is damaged: take an earlier one.",
            )
        self.seek(state["epoch"], state["consumed"])


def _is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _check(length: int, seed: int, batch_size: int | None, rank: int, world_size: int) -> None:
    if batch_size is not None and (not _is_count(batch_size) or batch_size < 1):
        raise UsageError(f"batch_size is {batch_size!r}", "a whole number, at least 1", batch_size=batch_size)
    if not _is_count(world_size) or not _is_count(rank) or rank >= world_size:
        raise UsageError(f"rank {rank!r} of {world_size!r} ranks", "0 <= rank < world_size", rank=rank)
    if not _is_count(seed):
        raise UsageError(f"seed is {seed!r}", "a whole number, at least 0", seed=seed)
    if length < 0:
        raise UsageError(f"length is {length}", "at least 0 items", length=length)


def item_number(item: SupportsIndex, length: int) -> int:
    """The number of an item of ``length``, counted from the end where it is negative.

    Raises
    ------
    IndexError, TypeError
    """
    number = operator.index(item)
    if not -length <= number < length:
        raise IndexError(f"item {number} of {length}")
    return number % length
