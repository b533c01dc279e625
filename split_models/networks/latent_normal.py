"""The normal distribution of a latent vector: samples of it, and its divergence from the standard normal."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import torch
from torch import Tensor


def draw(mean: Tensor, log_variance: Tensor) -> Tensor:
    """A sample (n, d) of each normal distribution; gradients reach mean and log variance (reparametrisation)."""
    return mean + torch.randn_like(mean) * torch.exp(0.5 * log_variance)


def divergence(mean: Tensor, log_variance: Tensor) -> Tensor:
    """Kullback-Leibler divergence from the standard normal in nat, mean over batch and latent dimensions.

    It is the mean over dimensions, as the squared error is the mean over pixels or vertices. With the sum over
    dimensions the paper's weights would drown the touch (see docs/decisions/0013-split-model-sizes.md).
    """
    return (-0.5 * (1.0 + log_variance - mean.square() - log_variance.exp())).mean()


def annealed(final: float, epoch: float, epochs: int) -> float:
    """Weight of the divergence at an epoch: it grows linearly from 0 to ``final`` over ``epochs``.

    Parameters
    ----------
    final : float
        Weight after annealing.
    epoch : float
        Epochs done, with fractions.
    epochs : int
        Epochs of annealing; 0 gives ``final`` at once.
    """
    return final * min(1.0, epoch / epochs) if epochs > 0 else final


@contextmanager
def drawn_alike(seed: int) -> Iterator[None]:
    """Within the context, PyTorch's CPU random numbers depend on the seed alone; then the generator is as before."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        yield
