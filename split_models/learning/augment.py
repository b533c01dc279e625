"""Pictures turned, mirrored, noisy, and of other contrast and brightness."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn import functional


@dataclass(frozen=True)
class Augmentation:
    """How far pictures are changed; 0 everywhere changes nothing.

    Parameters
    ----------
    rotation : rad, largest angle either way
    flip : chance of a mirrored picture, along each axis by itself
    noise : standard deviation, pictures in [-1, 1]
    contrast, brightness : largest change; of the factor about 1, of the shift about 0
    """

    rotation: float = 0.0
    flip: float = 0.0
    noise: float = 0.0
    contrast: float = 0.0
    brightness: float = 0.0

    def changed(self, pictures: Tensor) -> tuple[Tensor, Tensor]:
        """What a network is given and what it should give back, (n, 3, h, w) each.

        Noise is on what is given only: it cannot be foreseen. Randomness is that of the default generator.
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
        """Sets of pictures (n, 3, h, w), all mirrored and turned alike, by what one draw says."""
        chance = torch.rand(3, device=sets[0].device).tolist()
        for axis, one in ((3, chance[0]), (2, chance[1])):
            if one < self.flip:
                sets = tuple(some.flip(axis) for some in sets)
        if self.rotation:
            angle = (2 * chance[2] - 1) * self.rotation
            sets = tuple(turned(some, torch.full((len(some),), angle, device=some.device)) for some in sets)
        return sets


def turned(pictures: Tensor, angles: Tensor) -> Tensor:
    """Pictures (n, 3, h, w) turned about their middle by angles (n,), rad; the rim is mirrored outwards."""
    height, width = pictures.shape[2:]
    cosine, sine, zero = angles.cos(), angles.sin(), torch.zeros_like(angles)
    # grid coordinates run from -1 to 1 along both axes, whatever the picture's shape
    across = torch.stack([cosine, -sine * height / width, zero], dim=1)
    down = torch.stack([sine * width / height, cosine, zero], dim=1)
    grid = functional.affine_grid(torch.stack([across, down], dim=1), list(pictures.shape), align_corners=False)
    return functional.grid_sample(pictures, grid, padding_mode="reflection", align_corners=False)
