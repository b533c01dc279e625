"""Constant sparse matrices as gathers and sums, because exporters of networks do not support sparse products."""

from __future__ import annotations

import copy
from typing import TypeVar

import torch
from torch import Tensor, nn

from split_models.networks.sparse_map import SparseMap

N = TypeVar("N", bound=nn.Module)


class GatherMap(nn.Module):
    """The product of a `SparseMap` with values (n, ...), whose rows are padded to the longest one by weights of 0."""

    index: Tensor
    weight: Tensor

    def __init__(self, of: SparseMap) -> None:
        super().__init__()
        parts = dict(of.named_buffers())
        counts = parts["forward_pointer"].diff()
        longest = max(1, int(counts.max()))
        place = torch.arange(longest)
        is_there = place < counts[:, None]
        index = torch.zeros(of.shape[0], longest, dtype=torch.int64)
        weight = torch.zeros(of.shape[0], longest)
        index[is_there], weight[is_there] = parts["forward_index"], parts["forward_value"]
        self.register_buffer("index", index)
        self.register_buffer("weight", weight)

    def forward(self, values: Tensor) -> Tensor:
        """The product (m, ...) with values (n, ...)."""
        weight = self.weight.view(*self.weight.shape, *(1 for _ in values.shape[1:]))
        product: Tensor = (values[self.index] * weight).sum(dim=1)
        return product


def with_gathers(network: N) -> N:
    """A copy of a network, on the CPU, in which every `SparseMap` is a `GatherMap`."""
    copied = copy.deepcopy(network).cpu().eval()
    made: dict[SparseMap, GatherMap] = {}
    for module in list(copied.modules()):
        for name, child in list(module.named_children()):
            if isinstance(child, SparseMap):
                made.setdefault(child, GatherMap(child))
                setattr(module, name, made[child])
    return copied
