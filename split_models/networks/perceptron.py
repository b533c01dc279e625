"""Fully connected layers with ELU and dropout, of which projections and force heads are made."""

from __future__ import annotations

from collections.abc import Sequence

from torch import nn


def perceptron(inputs: int, layers: Sequence[int], outputs: int, dropout: Sequence[float]) -> nn.Sequential:
    """Linear layers, each followed by ELU, the first ones by dropout as well; the last layer is linear.

    Where the last of ``layers`` is as wide as the output it is the output; else a linear layer to the output is added.

    Parameters
    ----------
    inputs, outputs : int
    layers : widths
    dropout : shares dropped after the first layers
    """
    is_output = layers[-1] == outputs
    hidden = list(layers[:-1] if is_output else layers)
    parts: list[nn.Module] = []
    width = inputs
    for number, size in enumerate(hidden):
        parts += [nn.Linear(width, size), nn.ELU()]
        if number < len(dropout):
            parts.append(nn.Dropout(dropout[number]))
        width = size
    return nn.Sequential(*parts, nn.Linear(width, outputs))
