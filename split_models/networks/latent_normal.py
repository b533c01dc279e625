"""The normal distribution of a latent vector: drawn from, and held against the standard normal."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import torch
from torch import Tensor


def draw(mean: Tensor, log_variance: Tensor) -> Tensor:
    """A sample (n, d) of each distribution, through which gradients flow."""
    return mean + torch.randn_like(mean) * torch.exp(0.5 * log_variance)


def divergence(mean: Tensor, log_variance: Tensor) -> Tensor:
    """Kullback-Leibler divergence from the standard normal, nat, mean over batch and latent dimensions.

    The mean over dimensions, as the squared error is the mean over pixels or vertices: with the sum, the paper's
    weights drown the touch (see docs/decisions/0013-split-model-sizes.md).
    """
    return (-0.5 * (1.0 + log_variance - mean.square() - log_variance.exp())).mean()


def annealed(final: float, epoch: float, epochs: int) -> float:
    """The weight of the divergence: from 0 linearly to ``final`` over ``epochs``."""
    return final * min(1.0, epoch / epochs) if epochs > 0 else final


@contextmanager
def drawn_alike(seed: int) -> Iterator[None]:
    """Within, all that PyTorch draws depends on the seed alone; outside, nothing has happened."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        yield
