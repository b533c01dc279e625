"""Latent vectors of all frames of a part of the split, by each network of a recipe's run."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import torch
from torch import Tensor

from split_models.learning.data import TouchFrames
from split_models.networks.latent import encode_displacements, encode_pictures, subtract

if TYPE_CHECKING:
    from split_models.recipe.recipe_run import RecipeRun


def part_latents(recipe_run: RecipeRun, part: str, kind: str) -> Tensor:
    """Latent vectors (n, d) of the frames of a part, or their forces.

    Parameters
    ----------
    recipe_run : RecipeRun
        The run whose networks encode the frames.
    part : str
        Part of the recipe's split.
    kind : str
        An input of `RecipeRun.force_head`, or ``force`` for the contact forces (n, 3), N.
    """
    frames, latents = recipe_run.frames(part), recipe_run.recipe.models["latents"]
    if kind == "force":
        return torch.from_numpy(frames.forces())
    if kind == "mesh":
        vae = recipe_run.mesh_vae
        return _gathered(frames, lambda numbers: encode_displacements(vae, frames.displacements(numbers), latents))
    if kind == "image":
        return _gathered(
            frames, lambda numbers: encode_pictures(recipe_run.image_vae, frames.pictures(numbers), latents)
        )
    if kind == "deformation":
        return subtract(recipe_run.latents(part, "image"), _base(recipe_run, frames))
    is_split = kind == "projected_split"
    network = recipe_run.projection("image_to_mesh", is_split)
    given = recipe_run.latents(part, "deformation" if is_split else "image")
    with torch.no_grad():
        projected: Tensor = network(given.to(recipe_run.device)).cpu()
    return projected


def _base(recipe_run: RecipeRun, frames: TouchFrames) -> Tensor:
    """Latent vector of each frame's background (n, d); always the mean, because a background is one picture."""
    names = frames.sensor_names
    bases = encode_pictures(recipe_run.image_vae, np.stack([frames.background(name) for name in names]))
    return bases[torch.as_tensor([names.index(sensor) for sensor in frames.sensors])]


def _gathered(frames: TouchFrames, encode: Callable[[range], Tensor], chunk: int = 256) -> Tensor:
    """Latent vectors (n, d) of all frames, encoded ``chunk`` frames at a time."""
    starts = range(0, len(frames), chunk)
    return torch.cat([encode(range(start, min(start + chunk, len(frames)))) for start in starts])
