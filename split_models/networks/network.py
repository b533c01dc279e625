"""The base class of all networks: what a checkpoint needs to save a network and to build it again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import torch
from torch import Tensor, nn


class Network(nn.Module):
    """A network that its settings, its extras and its weights describe completely.

    Attributes
    ----------
    kind : str
        Its name in `split_models.learning.checkpoint.KINDS`.
    settings : dict
        The arguments of its class, as JSON values.
    convolves : bool
        Whether most of its work is convolutions of pictures.
    """

    kind = ""
    convolves = False
    settings: dict[str, Any]

    @property
    def device(self) -> torch.device:
        """The device that holds the weights."""
        return next(self.parameters()).device

    @property
    def topology(self) -> str:
        """Digest of the mesh that the network is for; empty where it is for none."""
        return ""

    def extras(self) -> dict[str, Tensor]:
        """Tensors that the network is built from, beside settings and weights."""
        return {}

    @classmethod
    def rebuilt(cls, settings: Mapping[str, Any], extras: Mapping[str, Tensor], topology: str) -> Self:
        """The network that a checkpoint describes, with initial weights.

        Parameters
        ----------
        settings : dict
            The arguments of the class.
        extras : dict of Tensor
            Tensors that `extras` gave.
        topology : str
            Digest of the mesh; empty where the network is for none.
        """
        return cls(**settings)
