"""An image VAE trained on latent arithmetic itself: pictures under other sensors' light; beyond the paper.

A touch changes the light that a camera sees by a ratio, nearly independently of the light. So a picture times another
sensor's background over its own background is nearly what the other sensor would have recorded. One picture without
contact is therefore enough to learn from a sensor of which nothing else was recorded.
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
"""Side in px of the square over which differences to the background are averaged before they count as a touch."""


class ArithmeticVaeObjective(Objective):
    """Loss of a beta-VAE that decodes Z_Image - Z_Base + Z_OtherBase to the same touch under another sensor's light.

    Parameters
    ----------
    network : ImageVae
    divergence_weight : float
        Weight of the divergence after annealing.
    anneal : int
        Epochs over which that weight grows from 0.
    augmentation : Augmentation
        Rotation, flips and noise, the same for a whole batch and for the backgrounds, so that each picture keeps its
        background. Relighting replaces changes of contrast and brightness.
    backgrounds : (s + t, h, w, 3) uint8
        Backgrounds of the pictures' sensors, in the order of ``batch["sensor"]``, then those of other sensors.
    relit : float
        Share of the pictures that the network gets under the light of a random background.
    exchanged : float
        Share of the pictures whose latent vector gets a random background before it is decoded.
    contact_weight : float
        Additional weight of errors where a picture shows the touch, which is a small part of the picture.
    gradient_weight : float
        Weight of the error of gradients (`objectives.gradient_error`) beside squared errors: edges are drawn sharper.
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
        gradient_weight: float = 0.0,
    ) -> None:
        super().__init__()
        self.network = network
        self.vae = network
        self.weight, self.anneal, self.augmentation = divergence_weight, anneal, augmentation
        self.relit, self.exchanged, self.contact_weight = relit, exchanged, contact_weight
        self.gradient_weight = gradient_weight
        self.backgrounds: Tensor
        pictures = torch.from_numpy(np.ascontiguousarray(backgrounds)).permute(0, 3, 1, 2)
        self.register_buffer("backgrounds", pictures, persistent=False)

    def forward(self, batch: Batch, epoch: float) -> Losses:
        """Scalars ``loss``, ``error`` and ``divergence`` of a batch with ``image`` (n, h, w, 3) and ``sensor`` (n,)."""
        pictures, own = batch["image"].permute(0, 3, 1, 2).float(), batch["sensor"]
        if not self.training:
            scaled = _scaled(pictures)
            emphasis = self._emphasis(pictures, self.backgrounds, own)
            return vae_losses(self.vae(scaled), scaled, self.weight, emphasis, self.gradient_weight)
        # draw the light of the input, and the light that the decoded picture should have
        pictures, backgrounds = self.augmentation.moved_together(pictures, self.backgrounds.float())
        input_light = self._some_other(own, self.relit)
        goal_light = self._some_other(input_light, self.exchanged)
        shown = _scaled(relight(pictures, backgrounds, own, input_light))
        shown = (shown + self.augmentation.noise * torch.randn_like(shown)).clamp(-1, 1)
        # exchange the background in latent space; place -1 is a zero vector, for pictures without a background
        mean, log_variance = self.vae.distribution(shown)
        base = torch.cat([self.vae.distribution(_scaled(backgrounds))[0], torch.zeros_like(mean[:1])])
        decoded = self.vae.decode(draw(mean, log_variance) - base[input_light] + base[goal_light])
        goal = _scaled(relight(pictures, backgrounds, own, goal_light))
        emphasis = self._emphasis(pictures, backgrounds, own)
        weight = annealed(self.weight, epoch, self.anneal)
        return vae_losses((decoded, mean, log_variance), goal, weight, emphasis, self.gradient_weight)

    def _emphasis(self, pictures: Tensor, backgrounds: Tensor, own: Tensor) -> Tensor | None:
        """Factors (n, 1, h, w) on errors, larger where a picture shows the touch; None without a weight."""
        if not self.contact_weight:
            return None
        difference = (pictures - backgrounds[own]).abs().amax(dim=1, keepdim=True)
        smooth = functional.avg_pool2d(difference, BLUR, stride=1, padding=BLUR // 2)
        is_touched = (smooth > THRESHOLD) & (own >= 0)[:, None, None, None]
        return 1.0 + self.contact_weight * is_touched

    def _some_other(self, places: Tensor, share: float) -> Tensor:
        """Places (n,) of backgrounds, of which a random share is drawn anew; -1, for no background, stays."""
        drawn = torch.randint(len(self.backgrounds), places.shape, device=places.device)
        is_drawn = (torch.rand(places.shape, device=places.device) < share) & (places >= 0)
        return torch.where(is_drawn, drawn, places)


def relight(pictures: Tensor, backgrounds: Tensor, own: Tensor, other: Tensor) -> Tensor:
    """Pictures (n, 3, h, w) under the light of another sensor: times its background over their own background.

    A picture whose own and other background are the same stays as it is, bit for bit.

    Parameters
    ----------
    pictures : (n, 3, h, w) in [0, 255]
    backgrounds : (s, 3, h, w) in [0, 255]
    own, other : (n,) int
        Places in ``backgrounds`` of each picture's own background and of the other one.
    """
    ratio = (backgrounds[other] + 1.0) / (backgrounds[own] + 1.0)
    return (pictures * ratio).clamp(max=255.0)


def _scaled(pictures: Tensor) -> Tensor:
    """Pictures in [-1, 1] from pictures in [0, 255]."""
    return pictures.div(127.5).sub(1.0)
