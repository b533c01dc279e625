"""Transfer between sensors in feature space: AdaIN with the target background's statistics, then decoding.

The features are the last ones of the encoder, a plane of 4 x 3 positions, because the decoder starts from no others. It
starts from the latent vector, which is a bottleneck; the decoder of AdaIN's source takes the features themselves.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from split_models.networks.image_vae import ImageVae, as_input
from split_models.networks.latent import CHUNK, decode_pictures
from split_models.networks.learned_backgrounds import Learned
from split_models.transfer.adaptive_instance_norm import adaptive_instance_norm
from split_models.transfer.picture_size import scaled
from tactiledata.arrays import PictureArray


@dataclass(frozen=True)
class AdainTransfer:
    """AdaIN in an image VAE's feature space, picture by picture; the source background is not used.

    Parameters
    ----------
    name : str
        Name of the method.
    vae : ImageVae
        Pictures are scaled to its size, and back to the target background's.
    model, recipe : str
        SHA-256 of the checkpoint's file, and of the recipe that it was trained by.
    scales : bool
        Whether source and target may have pictures of different sizes.

    Source
    ------
    Huang and Belongie, Arbitrary Style Transfer in Real-time with Adaptive Instance Normalization, ICCV 2017
    """

    name: str
    vae: ImageVae
    model: str = ""
    recipe: str = ""
    scales: bool = True

    @property
    def learned_from(self) -> Learned:
        """Sensors that the VAE was trained on, with their pictures without contact; empty where that is not known."""
        return self.vae.learned_from

    def transfer(
        self, images: PictureArray, source_background: PictureArray, target_background: PictureArray
    ) -> PictureArray:
        """Pictures (n, H, W, 3) uint8 with the target background's statistics, in that background's size.

        Parameters
        ----------
        images : (n, H, W, 3) uint8 RGB
            Pictures of the source sensor.
        source_background : (H, W, 3) uint8 RGB
            Not used.
        target_background : (H, W, 3) uint8 RGB
            The target without contact.
        """
        size = target_background.shape[:2]
        if not len(images):
            return np.zeros((0, *size, 3), np.uint8)
        latent = torch.cat(list(self._latent(images, target_background)))
        return scaled(decode_pictures(self.vae, latent), size)

    @torch.no_grad()
    def _latent(self, images: PictureArray, target_background: PictureArray) -> Iterator[Tensor]:
        """Yield latent vectors of the pictures' features with the target's style, some pictures at a time."""
        self.vae.eval()
        style = self._features(target_background[None])
        for start in range(0, len(images), CHUNK):
            features = self._features(images[start : start + CHUNK])
            yield self.vae.to_mean(adaptive_instance_norm(features, style).flatten(1)).cpu()

    def _features(self, pictures: PictureArray) -> Tensor:
        """Encoder features (n, C, h, w) of pictures (n, H, W, 3)."""
        given = as_input(torch.from_numpy(scaled(pictures, self.vae.size)).to(self.vae.device))
        features: Tensor = self.vae.encoder(given)
        return features
