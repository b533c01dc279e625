"""Fully connected layers with ELU and dropout, as projections and force heads use them."""

from __future__ import annotations

from collections.abc import Sequence

from torch import nn


def perceptron(inputs: int, layers: Sequence[int], outputs: int, dropout: Sequence[float]) -> nn.Sequential:
    """Linear layers, each followed by ELU, the first ones also by dropout; the last layer is linear.

    The last of ``layers`` is the output layer where it has the output's width; else a linear output layer is added.

    Parameters
    ----------
    inputs, outputs : int
        Sizes of the input and output vectors.
    layers : sequence of int
        Widths of the layers.
    dropout : sequence of float
        Shares that are dropped after the first layers, one for each.
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
