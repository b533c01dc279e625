"""An image VAE that learns the arithmetic it is used for: pictures under other sensors' light, beyond the paper.

A touch changes the light that a sensor's camera sees by a ratio, nearly whatever the light is. So a picture times
another sensor's background over its own is nearly what that other sensor would have seen, and one picture without
contact of a sensor is enough to learn from: units of which nothing else was ever recorded.
"""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from split_models.learning.augment import Augmentation
from split_models.learning.contact_region import THRESHOLD
from split_models.learning.items import Batch
from split_models.learning.objectives import Losses, Objective, vae_losses
from split_models.networks.image_vae import ImageVae
from split_models.networks.latent_normal import annealed, draw

BLUR = 5
"""px: differences to the background are averaged over so many before they count as a touch."""


class ArithmeticVaeObjective(Objective):
    """A beta-VAE that decodes Z_Image - Z_Base + another Z_Base to the same touch under that other sensor's light.

    Parameters
    ----------
    network : ImageVae
    divergence_weight : float
        Grows from 0 over ``anneal`` epochs.
    anneal : int
    augmentation : Augmentation
        Its rotation, flips and noise; they are the same for a whole batch and the backgrounds, so that these stay each
        other's. Other light stands for contrast and brightness.
    backgrounds : (s + t, h, w, 3) uint8
        Of the sensors that pictures are of, in the order of ``batch["sensor"]``, then of others.
    relit : float
        Share of the pictures that are given under the light of any of the backgrounds.
    exchanged : float
        Share whose latent vector changes its background for any of them before it is decoded.
    contact_weight : float
        By how much more squared errors count where a picture shows the touch: a touch is a small part of a picture.
    """

    def __init__(
        self,
        network: ImageVae,
        divergence_weight: float,
        anneal: int,
        augmentation: Augmentation,
        backgrounds: NDArray[np.uint8],
        relit: float,
        exchanged: float,
        contact_weight: float = 0.0,
    ) -> None:
        super().__init__()
        self.network = network
        self.vae = network
        self.weight, self.anneal, self.augmentation = divergence_weight, anneal, augmentation
        self.relit, self.exchanged, self.contact_weight = relit, exchanged, contact_weight
        self.backgrounds: Tensor
        pictures = torch.from_numpy(np.ascontiguousarray(backgrounds)).permute(0, 3, 1, 2)
        self.register_buffer("backgrounds", pictures, persistent=False)

    def forward(self, batch: Batch, epoch: float) -> Losses:
        """``loss``, ``error`` and ``divergence``."""
        pictures, own = batch["image"].permute(0, 3, 1, 2).float(), batch["sensor"]
        if not self.training:
            scaled = _scaled(pictures)
            return vae_losses(self.vae(scaled), scaled, self.weight, self._emphasis(pictures, self.backgrounds, own))
        pictures, backgrounds = self.augmentation.moved_together(pictures, self.backgrounds.float())
        given = self._some_other(own, self.relit)
        wanted = self._some_other(given, self.exchanged)
        shown = _scaled(relight(pictures, backgrounds, own, given))
        shown = (shown + self.augmentation.noise * torch.randn_like(shown)).clamp(-1, 1)
        mean, log_variance = self.vae.distribution(shown)
        base = torch.cat([self.vae.distribution(_scaled(backgrounds))[0], torch.zeros_like(mean[:1])])
        found = self.vae.decode(draw(mean, log_variance) - base[given] + base[wanted])
        goal = _scaled(relight(pictures, backgrounds, own, wanted))
        emphasis = self._emphasis(pictures, backgrounds, own)
        return vae_losses((found, mean, log_variance), goal, annealed(self.weight, epoch, self.anneal), emphasis)

    def _emphasis(self, pictures: Tensor, backgrounds: Tensor, own: Tensor) -> Tensor | None:
        """How much errors count, (n, 1, h, w): more where a picture differs from its background."""
        if not self.contact_weight:
            return None
        difference = (pictures - backgrounds[own]).abs().amax(dim=1, keepdim=True)
        smooth = functional.avg_pool2d(difference, BLUR, stride=1, padding=BLUR // 2)
        is_touched = (smooth > THRESHOLD) & (own >= 0)[:, None, None, None]
        return 1.0 + self.contact_weight * is_touched

    def _some_other(self, places: Tensor, share: float) -> Tensor:
        """A share of the places (n,) drawn anew among all backgrounds; those of pictures without one (-1) stay."""
        drawn = torch.randint(len(self.backgrounds), places.shape, device=places.device)
        is_drawn = (torch.rand(places.shape, device=places.device) < share) & (places >= 0)
        return torch.where(is_drawn, drawn, places)


def relight(pictures: Tensor, backgrounds: Tensor, own: Tensor, other: Tensor) -> Tensor:
    """Pictures (n, 3, h, w) in [0, 255] times the other background over their own, each (n,) a place in backgrounds.

    Where both places are one the picture stays as it is, bit for bit.
    """
    ratio = (backgrounds[other] + 1.0) / (backgrounds[own] + 1.0)
    return (pictures * ratio).clamp(max=255.0)


def _scaled(pictures: Tensor) -> Tensor:
    """Pictures in [0, 255] in [-1, 1]."""
    return pictures.div(127.5).sub(1.0)
