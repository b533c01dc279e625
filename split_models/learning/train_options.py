"""Options of a training, as a recipe states them; reading them does not need PyTorch."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

Schedule = Literal["decay", "one_cycle"]
RISING = 0.1
"""Share of a one-cycle training over which the learning rate rises."""
LEAST_RATE = 0.01
"""Share of the learning rate at which one cycle begins and ends."""


@dataclass(frozen=True)
class TrainOptions:
    """Options of a training.

    Parameters
    ----------
    epochs : int
        Largest number of epochs.
    batch_size : int
        Items in a batch, of all processes together.
    learning_rate : float
        First learning rate with ``decay``, largest one with ``one_cycle``.
    schedule : "decay" or "one_cycle"
        ``decay`` multiplies the rate by a factor after every epoch. ``one_cycle`` raises and lowers it once over all
        epochs (Smith and Topin 2019), which allows a larger rate.
    decay : float
        Factor on the learning rate after every epoch; not used by ``one_cycle``.
    weight_decay : float
        Weight of the squared parameters in Adam.
    patience : int
        Epochs without a better validation loss after which training stops; 0 never stops early.
    settle : int
        Epochs before patience begins to count, during which a weight is annealed.
    seed : int
        Seed of the order of items and of all random numbers.
    save_seconds : float
        Longest time between checkpoints within an epoch.
    accumulate : int
        Number of pieces of a batch that go through the network one after another, and whose gradients are added: each
        step has the same items in a fraction of the memory.
    """

    epochs: int
    batch_size: int
    learning_rate: float = 1e-3
    schedule: Schedule = "decay"
    decay: float = 1.0
    weight_decay: float = 0.0
    patience: int = 0
    settle: int = 0
    seed: int = 0
    save_seconds: float = 120.0
    accumulate: int = 1

    @property
    def shaping(self) -> dict[str, Any]:
        """Options that influence the weights; a batch in one piece is as before there were pieces."""
        shaping = {**vars(self), "save_seconds": 0.0}
        if self.accumulate == 1:
            del shaping["accumulate"]
        return shaping

    def rate_at(self, epoch: float) -> float:
        """The learning rate after a number of epochs, which may be a fraction."""
        if self.schedule == "decay":
            return self.learning_rate * self.decay ** math.floor(epoch)
        done = epoch / self.epochs
        fraction = done / RISING if done < RISING else (1.0 - done) / (1.0 - RISING)
        return self.learning_rate * (LEAST_RATE + (1.0 - LEAST_RATE) * 0.5 * (1.0 - math.cos(math.pi * fraction)))
