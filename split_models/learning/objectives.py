"""The objective of each network: its loss for a batch, in parts; the sum to be minimised is called ``loss``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import torch
from torch import Tensor, nn

from split_models.learning.augment import Augmentation
from split_models.learning.items import Batch
from split_models.networks.image_vae import ImageVae, as_input
from split_models.networks.latent_normal import annealed, divergence
from split_models.networks.mesh_vae import MeshVae
from split_models.networks.network import Network

Losses = dict[str, Tensor]


class Objective(nn.Module):
    """A network and its loss.

    ``forward(batch, epoch)`` gives the losses; ``epoch`` counts with fractions. The validation loss has the weights of
    the end of all annealing and nothing random, so that epochs can be compared.
    """

    network: Network


class ImageVaeObjective(Objective):
    """Squared error of pictures in [-1, 1], plus the divergence, whose weight grows from 0 over ``anneal`` epochs.

    Parameters
    ----------
    network : ImageVae
    divergence_weight : float
        Weight of the divergence after annealing.
    anneal : int
        Epochs over which the weight grows.
    augmentation : Augmentation
        Random changes of the training pictures.
    """

    def __init__(self, network: ImageVae, divergence_weight: float, anneal: int, augmentation: Augmentation) -> None:
        super().__init__()
        self.network = network
        self.vae = network
        self.weight, self.anneal, self.augmentation = divergence_weight, anneal, augmentation

    def forward(self, batch: Batch, epoch: float) -> Losses:
        """Scalars ``loss``, ``error`` and ``divergence`` of a batch with ``image`` (n, h, w, 3), uint8."""
        pictures = as_input(batch["image"])
        given, target = self.augmentation.changed(pictures) if self.training else (pictures, pictures)
        weight = annealed(self.weight, epoch, self.anneal) if self.training else self.weight
        return vae_losses(self.vae(given), target, weight)


class MeshVaeObjective(Objective):
    """Squared error of displacements, scaled vertex by vertex, plus the weighted divergence."""

    def __init__(self, network: MeshVae, divergence_weight: float) -> None:
        super().__init__()
        self.network = network
        self.vae = network
        self.weight = divergence_weight

    def forward(self, batch: Batch, epoch: float) -> Losses:
        """Scalars ``loss``, ``error`` and ``divergence`` of a batch with ``mesh`` (n, v, 3), m."""
        moved = batch["mesh"]
        return vae_losses(self.vae(moved), self.vae.scaled(moved), self.weight)


def vae_losses(
    output: tuple[Tensor, Tensor, Tensor],
    target: Tensor,
    weight: float,
    emphasis: Tensor | None = None,
    gradient_weight: float = 0.0,
) -> Losses:
    """Losses of a beta-VAE: the squared error of its reconstruction, the divergence, and their weighted sum.

    Parameters
    ----------
    output : (reconstruction, mean, log variance)
        The VAE's output: (n, ...) and twice (n, latent).
    target : (n, ...)
        What the reconstruction should be.
    weight : float
        Weight of the divergence.
    emphasis : Tensor, optional
        Factors on the squared errors, of ``target``'s shape or broadcast to it.
    gradient_weight : float
        Weight of the error of gradients, `gradient_error`, beside the squared error; for pictures only.

    Returns
    -------
    dict of scalar Tensor
        ``loss``, with a gradient; ``error`` and ``divergence``, without.
    """
    reconstruction, mean, log_variance = (part.float() for part in output)
    squares = (reconstruction - target).square()
    error = (squares if emphasis is None else squares * emphasis).mean()
    if gradient_weight:
        error = error + gradient_weight * gradient_error(reconstruction - target, emphasis)
    spread = divergence(mean, log_variance)
    return {"loss": error + weight * spread, "error": error.detach(), "divergence": spread.detach()}


def gradient_error(difference: Tensor, emphasis: Tensor | None = None) -> Tensor:
    """Mean absolute difference between neighbouring pixels of a difference of pictures, along rows plus along columns.

    Squared errors alone are least where a network that is unsure of an edge draws it softly.

    Parameters
    ----------
    difference : (n, 3, h, w)
        Picture less goal.
    emphasis : (n, 1, h, w), optional
        Factors; a difference of two pixels has that of the latter.

    Source: the gradient difference loss of Mathieu, Couprie and LeCun (ICLR 2016), eq. 6 with exponent 1, here with the
    sign of each difference.
    """
    along, down = difference.diff(dim=-1).abs(), difference.diff(dim=-2).abs()
    if emphasis is not None:
        along, down = along * emphasis[..., 1:], down * emphasis[..., 1:, :]
    return along.mean() + down.mean()


class Regression(Objective):
    """Mean squared error between a network's output for ``batch[given]`` and ``batch[target]``.

    Parameters
    ----------
    network : Network
    given, target : str
        Names of the input and of the target in the batch.
    prepare_given, prepare_target : callable, optional
        Functions of a tensor, applied to the input before the network and to the target before the comparison.
    """

    def __init__(
        self,
        network: Network,
        given: str,
        target: str,
        prepare_given: Callable[[Tensor], Tensor] | None = None,
        prepare_target: Callable[[Tensor], Tensor] | None = None,
    ) -> None:
        super().__init__()
        self.network = network
        self._given, self._target = given, target
        self._prepare_given, self._prepare_target = prepare_given, prepare_target

    def forward(self, batch: Batch, epoch: float) -> Losses:
        """The scalar ``loss`` of a batch; the epoch is not used."""
        given, target = batch[self._given], batch[self._target]
        output = self.network(given if self._prepare_given is None else self._prepare_given(given))
        target = target if self._prepare_target is None else self._prepare_target(target)
        return {"loss": nn.functional.mse_loss(output.float(), target)}


def scaled_forces(mean: Any, spread: Any) -> Callable[[Tensor], Tensor]:
    """A function that scales forces (n, 3), N, by a mean and a spread (3,), N, to mean 0 and standard deviation 1."""
    centre, width = torch.as_tensor(mean).float(), torch.as_tensor(spread).float()
    return lambda forces: (forces - centre.to(forces.device)) / width.to(forces.device)
