"""Where a training stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass
class TrainingState:
    """Where training stands, as JSON values in the checkpoint."""

    order: dict[str, Any] = field(default_factory=dict)
    sums: dict[str, float] = field(default_factory=dict)
    seconds: float = 0.0
    rows: list[dict[str, float]] = field(default_factory=list)
    best: float = float("inf")
    best_epoch: int = -1
    is_over: bool = False

    def document(self) -> dict[str, Any]:
        """As JSON values."""
        return {**vars(self), "best": None if self.best_epoch < 0 else self.best}

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> TrainingState:
        """The inverse of `document`."""
        best = document["best"]
        return cls(**{**document, "best": float("inf") if best is None else best})
