"""What each network learns: its loss of a batch, in parts; the total is called ``loss``."""

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

    ``forward(batch, epoch)`` gives the losses; ``epoch`` counts with fractions. What is validated is the loss at the
    end of all annealing, without anything random, so that epochs can be compared.
    """

    network: Network


class ImageVaeObjective(Objective):
    """Squared error of pictures in [-1, 1], and the divergence, whose weight grows from 0 over ``anneal`` epochs."""

    def __init__(self, network: ImageVae, divergence_weight: float, anneal: int, augmentation: Augmentation) -> None:
        super().__init__()
        self.network = network
        self.vae = network
        self.weight, self.anneal, self.augmentation = divergence_weight, anneal, augmentation

    def forward(self, batch: Batch, epoch: float) -> Losses:
        """``loss``, ``error`` and ``divergence``."""
        pictures = as_input(batch["image"])
        given, wanted = self.augmentation.changed(pictures) if self.training else (pictures, pictures)
        weight = annealed(self.weight, epoch, self.anneal) if self.training else self.weight
        return vae_losses(self.vae(given), wanted, weight)


class MeshVaeObjective(Objective):
    """Squared error of displacements, scaled vertex by vertex, and the divergence."""

    def __init__(self, network: MeshVae, divergence_weight: float) -> None:
        super().__init__()
        self.network = network
        self.vae = network
        self.weight = divergence_weight

    def forward(self, batch: Batch, epoch: float) -> Losses:
        """``loss``, ``error`` and ``divergence``."""
        moved = batch["mesh"]
        return vae_losses(self.vae(moved), self.vae.scaled(moved), self.weight)


def vae_losses(
    output: tuple[Tensor, Tensor, Tensor], wanted: Tensor, weight: float, emphasis: Tensor | None = None
) -> Losses:
    """The losses of a beta-VAE whose output is a reconstruction, mean and log variance.

    ``emphasis``, of ``wanted``'s shape or one that spreads to it, is what the squared errors are multiplied by.
    """
    found, mean, log_variance = (one.float() for one in output)
    squares = (found - wanted).square()
    error = (squares if emphasis is None else squares * emphasis).mean()
    spread = divergence(mean, log_variance)
    return {"loss": error + weight * spread, "error": error.detach(), "divergence": spread.detach()}


class Regression(Objective):
    """Squared error of what a network makes of ``batch[given]``.

    Parameters
    ----------
    network : Network
    given, wanted : str
        Names in the batch.
    prepare_given, prepare_wanted : callable, optional
        Tensor -> tensor, before the network and before the comparison.
    """

    def __init__(
        self,
        network: Network,
        given: str,
        wanted: str,
        prepare_given: Callable[[Tensor], Tensor] | None = None,
        prepare_wanted: Callable[[Tensor], Tensor] | None = None,
    ) -> None:
        super().__init__()
        self.network = network
        self._given, self._wanted = given, wanted
        self._prepare_given, self._prepare_wanted = prepare_given, prepare_wanted

    def forward(self, batch: Batch, epoch: float) -> Losses:
        """``loss``."""
        given, wanted = batch[self._given], batch[self._wanted]
        found = self.network(given if self._prepare_given is None else self._prepare_given(given))
        wanted = wanted if self._prepare_wanted is None else self._prepare_wanted(wanted)
        return {"loss": nn.functional.mse_loss(found.float(), wanted)}


def scaled_forces(mean: Any, spread: Any) -> Callable[[Tensor], Tensor]:
    """Forces (n, 3), N, with mean 0 and spread 1."""
    middle, width = torch.as_tensor(mean).float(), torch.as_tensor(spread).float()
    return lambda forces: (forces - middle.to(forces.device)) / width.to(forces.device)
