"""The training loop of every network: it can be killed, resumed, and shared between processes."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import torch
from torch import distributed
from torch.nn.parallel import DistributedDataParallel

from split_models.learning.checkpoint import Checkpoint, TrainedOn, load_checkpoint, require_stamps, save_checkpoint
from split_models.learning.curves import write_curves
from split_models.learning.device import Ranks, uses_bfloat16
from split_models.learning.items import Batch, Items
from split_models.learning.objectives import Losses, Objective
from split_models.learning.require_finite import require_finite_batch, require_finite_losses, require_finite_validation
from split_models.learning.train_options import TrainOptions
from split_models.learning.training_state import TrainingState
from split_models.networks.network import Network
from tactiledata.contract.progress import Progress
from tactiledata.errors import UsageError
from tactiledata.loaders.order import Order

T = TypeVar("T")

LAST, BEST = "last.pt", "best.pt"
"""Files of the latest state, from which training resumes, and of the weights with the least validation loss."""


@dataclass(frozen=True)
class Trained:
    """A trained network with the weights of its best epoch, and its training curve.

    Parameters
    ----------
    network : Network
    rows : list of dict
        Losses, learning rate and seconds of each epoch.
    best_epoch : int
        Epoch with the least validation loss.
    """

    network: Network
    rows: list[dict[str, float]]
    best_epoch: int


def train(
    objective: Objective,
    items: Items,
    validation: Items,
    options: TrainOptions,
    folder: Path,
    stamps: TrainedOn,
    device: torch.device,
    ranks: Ranks | None = None,
    tell: Progress | None = None,
) -> Trained:
    """A trained network: trained from the start, resumed where training was killed, or read where it is complete.

    Whenever the process is killed, the same call ends with the same losses: the order of items and all random numbers
    of a step depend on the seed, the epoch and the step alone.

    Parameters
    ----------
    objective : Objective
        The network and its loss.
    items, validation : Items
        Items to train on, and items whose loss selects the best epoch.
    options : TrainOptions
        Epochs, batch size, learning rate, patience and seed.
    folder : Path
        Folder for ``last.pt``, ``best.pt``, ``curve.csv`` and ``curve.json``.
    stamps : TrainedOn
        Digests of what the weights depend on; a checkpoint with others is refused.
    device : torch.device
    ranks : Ranks, optional
        Number of this process among those that train together; one process unless given.
    tell : callable, optional
        Called after each epoch with epochs done, epochs in all, and the losses in words.

    Raises
    ------
    UsageError
        There is nothing to train on or to validate on, or the batch size does not divide by the processes.
    NotFinite
        NaN or infinity in a batch or in a loss; the message names frames.
    CheckpointError
        The folder holds weights that were trained on something else.
    """
    ranks = ranks or Ranks()
    for what, listed in (("train", items), ("validate", validation)):
        if not len(listed):
            raise UsageError(f"nothing to {what} the {objective.network.kind} on", "at least one item", "")
    with torch.random.fork_rng(devices=[device] if device.type == "cuda" else []):
        loop = _Loop(objective, items, validation, options, folder, stamps, device, ranks=ranks, tell=tell)
        loop.resume()
        while not loop.progress.is_over:
            loop.epoch()
    loop.ranks.wait()
    kept = load_checkpoint(folder / BEST)
    objective.network.load_state_dict(dict(kept.weights))
    objective.network.to(device).eval()
    return Trained(objective.network, loop.progress.rows, loop.progress.best_epoch)


class _Loop:
    """State of one training: objective, items, optimiser, order of items and progress."""

    def __init__(
        self,
        objective: Objective,
        items: Items,
        validation: Items,
        options: TrainOptions,
        folder: Path,
        stamps: TrainedOn,
        device: torch.device,
        ranks: Ranks,
        tell: Progress | None,
    ) -> None:
        self.objective = objective.to(device)
        self.items, self.validation, self.options = items, validation, options
        self.folder, self.stamps, self.device, self.ranks = folder, stamps, device, ranks
        self.tell = tell if ranks.is_first else None
        if options.batch_size % ranks.world:
            raise UsageError(
                f"batches of {options.batch_size} for {ranks.world} processes", "a batch size that divides", ""
            )
        self.optimiser = torch.optim.Adam(
            [weight for weight in objective.parameters() if weight.requires_grad],
            lr=options.learning_rate,
            weight_decay=options.weight_decay,
        )
        self.order = Order(
            len(items),
            seed=options.seed,
            batch_size=options.batch_size // ranks.world,
            rank=ranks.rank,
            world_size=ranks.world,
            fingerprint=items.fingerprint,
        )
        self.steps = -(-len(items) // self.order.stride)
        self.progress = TrainingState()
        self.saved = time.monotonic()

    def resume(self) -> None:
        """Load the last checkpoint where there is one, and prepare the gradient exchange between processes."""
        path = self.folder / LAST
        self.ranks.wait()
        if path.exists():
            kept = load_checkpoint(path)
            require_stamps(kept.stamps, self.stamps, str(path))
            self.objective.network.load_state_dict(dict(kept.weights))
            self.progress = TrainingState.from_document(kept.progress)
            if not self.progress.is_over:
                self.optimiser.load_state_dict(dict(kept.optimiser))
            self.order.load_state_dict(self.progress.order)
        self.learner = (
            DistributedDataParallel(self.objective, broadcast_buffers=False) if self.ranks.world > 1 else self.objective
        )

    def epoch(self) -> None:
        """Train one epoch, or the rest of an interrupted one, then validate and save."""
        epoch, started = self.order.epoch, time.monotonic()
        self.objective.train()
        spent, consumed = self.progress.seconds, self.order.consumed
        for numbers, batch in _ahead((numbers, self.items.batch(numbers)) for numbers in self.order):
            consumed = min(consumed + self.order.stride, len(self.items))
            self._step(batch, numbers, epoch, consumed)
            self.progress.seconds = spent + time.monotonic() - started
            if time.monotonic() - self.saved > self.options.save_seconds and consumed < len(self.items):
                self.progress.order = {**self.order.state_dict(), "epoch": epoch, "consumed": consumed}
                self._save()
        self._end_epoch(epoch)

    def _step(self, batch: Batch, numbers: list[int], epoch: int, consumed: int) -> None:
        """Train on one batch; ``consumed`` counts the epoch's items up to its end."""
        step = -(-consumed // self.order.stride)
        passed = epoch + (step - 1) / self.steps
        for group in self.optimiser.param_groups:
            group["lr"] = self.options.rate_at(passed)
        # seeded by position, so that a resumed training draws the same numbers
        torch.manual_seed(_seed(self.options.seed, epoch, step, self.ranks.rank))
        require_finite_batch(batch, numbers, self.items)
        moved = {name: values.to(self.device, non_blocking=True) for name, values in batch.items()}
        self.optimiser.zero_grad(set_to_none=True)
        spans = self._pieces(len(numbers))
        for piece, span in enumerate(spans):
            with self._unshared(piece + 1 < len(spans)):
                part = {name: values[span] for name, values in moved.items()}
                losses = self._losses(self.learner, part, passed)
                listed = numbers[span]
                kind, rate = self.objective.network.kind, self.options.learning_rate
                require_finite_losses(losses, kind, epoch, self.items, listed, rate)
                (losses["loss"] * (len(listed) / len(numbers))).backward()
            self._count(self.progress.sums, losses, len(listed))
        self.optimiser.step()

    def _pieces(self, count: int) -> list[slice]:
        """Pieces of a batch of ``count`` items that go through the network together."""
        size = -(-count // min(self.options.accumulate, count))
        return [slice(start, min(start + size, count)) for start in range(0, count, size)]

    def _unshared(self, is_early: bool) -> AbstractContextManager[Any]:
        """A context without an exchange of gradients: processes exchange those of the last piece, with all others."""
        if is_early and isinstance(self.learner, DistributedDataParallel):
            return self.learner.no_sync()
        return nullcontext()

    def _losses(self, learner: torch.nn.Module, batch: Batch, epoch: float) -> Losses:
        """Losses of a batch, in bfloat16 where the device gains by it."""
        is_used = uses_bfloat16(self.device, self.objective.network.convolves)
        with torch.autocast(self.device.type, torch.bfloat16, enabled=is_used):
            losses: Losses = learner(batch, epoch)
        return losses

    @staticmethod
    def _count(sums: dict[str, float], losses: Losses, count: int) -> None:
        """Add the losses of ``count`` items to their sums."""
        for name, value in losses.items():
            sums[name] = sums.get(name, 0.0) + value.item() * count
        sums["items"] = sums.get("items", 0.0) + count

    def _end_epoch(self, epoch: int) -> None:
        """Validate, append the epoch's row, decide whether training is over, and save."""
        progress = self.progress
        self.order.set_epoch(epoch + 1)
        names = sorted(set(progress.sums) - {"items"})
        trained = self._shared(progress.sums, names)
        checked = self._shared(self._validated(epoch), names)
        require_finite_validation(checked, self.objective.network.kind, epoch)
        progress.rows.append(
            {
                "epoch": epoch,
                "learning_rate": self.options.rate_at(epoch),
                **{f"train_{name}": value for name, value in trained.items()},
                **{f"val_{name}": value for name, value in checked.items()},
                "seconds": round(progress.seconds, 3),
            }
        )
        progress.sums, progress.seconds = {}, 0.0
        # patience counts from the best epoch, and not before annealing has ended
        is_better = checked["loss"] < progress.best
        if is_better:
            progress.best, progress.best_epoch = checked["loss"], epoch
        waited = epoch - max(progress.best_epoch, self.options.settle)
        progress.is_over = epoch + 1 >= self.options.epochs or 0 < self.options.patience <= waited
        progress.order = self.order.state_dict()
        if self.ranks.is_first and is_better:
            save_checkpoint(self.folder / BEST, Checkpoint.of(self.objective.network, self.stamps))
        self._save()
        if self.tell is not None:
            words = f"train {trained['loss']:.4g}, val {checked['loss']:.4g}"
            self.tell(self.options.epochs if progress.is_over else epoch + 1, self.options.epochs, words)

    def _validated(self, epoch: int) -> dict[str, float]:
        """Sums of the validation losses over this process's share of the items."""
        self.objective.eval()
        sums: dict[str, float] = {"items": 0.0}
        size = self.options.batch_size
        starts = list(range(0, len(self.validation), size))[self.ranks.rank :: self.ranks.world]
        spans = [range(start, min(start + size, len(self.validation))) for start in starts]
        with torch.no_grad():
            for span, batch in _ahead((span, self.validation.batch(span)) for span in spans):
                moved = {name: values.to(self.device) for name, values in batch.items()}
                self._count(sums, self._losses(self.objective, moved, float(epoch)), len(span))
        return sums

    def _shared(self, sums: Mapping[str, float], names: list[str]) -> dict[str, float]:
        """Mean losses by name over the items of all processes."""
        values = torch.tensor([*(sums.get(name, 0.0) for name in names), sums["items"]], dtype=torch.float64)
        if self.ranks.world > 1:
            moved = values.to(self.device)
            distributed.all_reduce(moved)
            values = moved.cpu()
        return {name: (value / values[-1]).item() for name, value in zip(names, values[:-1], strict=True)}

    def _save(self) -> None:
        """Write the curve, then the last checkpoint, which says what is done; only the first process does."""
        self.saved = time.monotonic()
        if not self.ranks.is_first:
            return
        optimiser = {} if self.progress.is_over else self.optimiser.state_dict()
        kept = Checkpoint.of(self.objective.network, self.stamps, self.progress.document(), optimiser)
        write_curves(self.folder, self.progress.rows)
        save_checkpoint(self.folder / LAST, kept)


def _seed(*parts: int) -> int:
    """A seed of 63 bits that depends on all parts."""
    digest = hashlib.sha256(",".join(map(str, parts)).encode()).digest()
    return int.from_bytes(digest[:8], "big") >> 1


def _ahead(values: Iterable[T]) -> Iterator[T]:
    """Yield the same values in the same order; a thread computes the next one meanwhile."""
    iterator = iter(values)
    end = object()
    with ThreadPoolExecutor(1) as pool:
        future = pool.submit(next, iterator, end)
        while (value := future.result()) is not end:
            future = pool.submit(next, iterator, end)
            yield value  # type: ignore[misc]
