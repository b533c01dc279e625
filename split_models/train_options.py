"""How a network learns, as a recipe says it; PyTorch is not needed to read it."""

from __future__ import annotations

from dataclasses import dataclass


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
    decay : float
        Factor on the learning rate after every epoch.
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
    decay: float = 1.0
    weight_decay: float = 0.0
    patience: int = 0
    settle: int = 0
    seed: int = 0
    save_seconds: float = 120.0
