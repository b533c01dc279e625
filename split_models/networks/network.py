"""What every network offers, so that a checkpoint can keep it and build it again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import torch
from torch import Tensor, nn


class Network(nn.Module):
    """A network that its settings, its extras and its weights say all about.

    Attributes
    ----------
    kind : str
        Its name in `split_models.learning.checkpoint.KINDS`.
    settings : dict
        JSON values: the arguments of its class.
    convolves : bool
        Whether most of its work is convolutions of pictures.
    """

    kind = ""
    convolves = False
    settings: dict[str, Any]

    @property
    def device(self) -> torch.device:
        """Where the weights are."""
        return next(self.parameters()).device

    @property
    def topology(self) -> str:
        """Digest of the mesh that it is for; empty where it is for none."""
        return ""

    def extras(self) -> dict[str, Tensor]:
        """Numbers beside settings and weights that it is built from."""
        return {}

    @classmethod
    def rebuilt(cls, settings: Mapping[str, Any], extras: Mapping[str, Tensor], topology: str) -> Self:
        """The network of a checkpoint, before its weights are loaded."""
        return cls(**settings)
