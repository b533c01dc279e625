"""Random changes of training pictures: rotation, mirroring, noise, contrast and brightness."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn import functional


@dataclass(frozen=True)
class Augmentation:
    """Ranges of random changes of pictures; 0 everywhere changes nothing.

    Parameters
    ----------
    rotation : float, rad
        Largest angle of a rotation, either way.
    flip : float
        Probability that a picture is mirrored, along each axis independently.
    noise : float
        Standard deviation of the noise, for pictures in [-1, 1].
    contrast, brightness : float
        Largest deviation of the contrast's factor from 1, and of the brightness' shift from 0.
    """

    rotation: float = 0.0
    flip: float = 0.0
    noise: float = 0.0
    contrast: float = 0.0
    brightness: float = 0.0

    def changed(self, pictures: Tensor) -> tuple[Tensor, Tensor]:
        """The network's input and its goal, (n, 3, h, w) each, after one random change of each picture.

        Only the input is noisy, because noise cannot be predicted. Random numbers come from PyTorch's default
        generator.
        """
        count, device = len(pictures), pictures.device

        def random() -> Tensor:
            return torch.rand(count, 1, 1, 1, device=device)

        if self.flip:
            pictures = torch.where(random() < self.flip, pictures.flip(3), pictures)
            pictures = torch.where(random() < self.flip, pictures.flip(2), pictures)
        if self.rotation:
            pictures = turned(pictures, (2 * random().flatten() - 1) * self.rotation)
        if self.contrast or self.brightness:
            factor = 1 + (2 * random() - 1) * self.contrast
            shift = (2 * random() - 1) * self.brightness
            middle = pictures.mean(dim=(2, 3), keepdim=True)
            pictures = ((pictures - middle) * factor + middle + shift).clamp(-1, 1)
        given = (pictures + self.noise * torch.randn_like(pictures)).clamp(-1, 1) if self.noise else pictures
        return given, pictures

    def moved_together(self, *sets: Tensor) -> tuple[Tensor, ...]:
        """Sets of pictures (n, 3, h, w), all mirrored and rotated in the same way, which is drawn once."""
        chance = torch.rand(3, device=sets[0].device).tolist()
        for axis, probability in ((3, chance[0]), (2, chance[1])):
            if probability < self.flip:
                sets = tuple(pictures.flip(axis) for pictures in sets)
        if self.rotation:
            angle = (2 * chance[2] - 1) * self.rotation
            sets = tuple(
                turned(pictures, torch.full((len(pictures),), angle, device=pictures.device)) for pictures in sets
            )
        return sets


def turned(pictures: Tensor, angles: Tensor) -> Tensor:
    """Pictures (n, 3, h, w) rotated about their centre by angles (n,), rad; pixels beyond the rim are reflected."""
    height, width = pictures.shape[2:]
    cosine, sine, zero = angles.cos(), angles.sin(), torch.zeros_like(angles)
    # grid coordinates run from -1 to 1 along both axes, whatever the picture's shape
    across = torch.stack([cosine, -sine * height / width, zero], dim=1)
    down = torch.stack([sine * width / height, cosine, zero], dim=1)
    grid = functional.affine_grid(torch.stack([across, down], dim=1), list(pictures.shape), align_corners=False)
    return functional.grid_sample(pictures, grid, padding_mode="reflection", align_corners=False)
