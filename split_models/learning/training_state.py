"""The state of a training between epochs and steps, for its checkpoint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass
class TrainingState:
    """State of a training, from which it resumes; `document` gives it as JSON values.

    Attributes
    ----------
    order : dict
        State of the order of items.
    sums : dict
        Sums of the losses over the present epoch's items so far, and their number as ``items``.
    seconds : float
        Time spent in the present epoch.
    rows : list of dict
        Rows of the finished epochs.
    best : float
        Least validation loss so far.
    best_epoch : int
        Its epoch; -1 before the first epoch ends.
    is_over : bool
        Whether training is complete.
    """

    order: dict[str, Any] = field(default_factory=dict)
    sums: dict[str, float] = field(default_factory=dict)
    seconds: float = 0.0
    rows: list[dict[str, float]] = field(default_factory=list)
    best: float = float("inf")
    best_epoch: int = -1
    is_over: bool = False

    def document(self) -> dict[str, Any]:
        """The state as JSON values; infinity becomes None."""
        return {**vars(self), "best": None if self.best_epoch < 0 else self.best}

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> TrainingState:
        """The state that `document` described."""
        best = document["best"]
        return cls(**{**document, "best": float("inf") if best is None else best})
