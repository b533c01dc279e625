"""How a network learns, as a recipe says it; PyTorch is not needed to read it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

Schedule = Literal["decay", "one_cycle"]
RISING = 0.1
"""Share of a one-cycle training over which the learning rate rises."""
LEAST_RATE = 0.01
"""Of the learning rate: where one cycle begins and ends."""


@dataclass(frozen=True)
class TrainOptions:
    """How a network learns.

    Parameters
    ----------
    epochs : int
        At most.
    batch_size : int
        Of all processes together.
    learning_rate : float
    schedule : "decay" or "one_cycle"
        By a factor after every epoch; or up to the learning rate and down again, once, over all epochs (Smith and Topin
        2019), which allows a larger one.
    decay : float
        Factor on the learning rate after every epoch; of no meaning to one cycle.
    weight_decay : float
    patience : int
        Epochs without a better validation loss after which it stops; 0: never.
    settle : int
        Epochs before patience begins to count: those in which a weight is annealed.
    seed : int
    save_seconds : float
        A checkpoint is kept at least so often, within epochs as well.
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

    def rate_at(self, epoch: float) -> float:
        """The learning rate after so many epochs, fractions counted."""
        if self.schedule == "decay":
            return self.learning_rate * self.decay ** math.floor(epoch)
        done = epoch / self.epochs
        along = done / RISING if done < RISING else (1.0 - done) / (1.0 - RISING)
        return self.learning_rate * (LEAST_RATE + (1.0 - LEAST_RATE) * 0.5 * (1.0 - math.cos(math.pi * along)))
