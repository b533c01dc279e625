"""Both projections trained together, so that mesh to picture to mesh is the identity; beyond the paper.

The plain projections are trained on latent vectors of recorded pictures and simulated meshes only. In a cycle each of
them also gets the output of the other one, after it was decoded and encoded again.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import torch
from torch import Tensor, nn

from split_models.learning.items import Batch, TensorItems
from split_models.learning.objectives import Losses, Objective
from split_models.networks.latent import (
    LatentImageToMesh,
    LatentMeshToImage,
    decode_displacements,
    decode_pictures,
    encode_displacements,
    encode_pictures,
    project,
)
from split_models.networks.network import Network
from split_models.networks.projection import Projection
from split_models.recipe.recipe_run import RecipeRun

MESHES, PICTURES = "mesh_again", "deformation_again"
"""Names in a batch of latent vectors that were decoded and encoded again."""
CHUNK = 256
"""Frames that are decoded and encoded together."""


class CyclePair(Network):
    """Two projections: ``forth`` from the mesh's latent space to the deformation's, and ``back``.

    Parameters
    ----------
    forth, back : dict
        Settings of each `Projection`.
    """

    kind = "cycle_pair"

    def __init__(self, forth: Mapping[str, Any], back: Mapping[str, Any]) -> None:
        super().__init__()
        self.settings = {"forth": dict(forth), "back": dict(back)}
        self.forth, self.back = Projection(**forth), Projection(**back)


class CycleObjective(Objective):
    """Squared errors of both projections, of one after the other, and of both on their own re-encoded outputs.

    Each error is a share of the variance of its target. The vectors of pictures vary far less than those of meshes;
    without the scaling the errors of meshes would dominate.

    Parameters
    ----------
    network : CyclePair
    weight : float
        Weight of the cycle error: one projection after the other, in latent space.
    own_weight : float
        Weight of the error on latent vectors that were decoded and encoded again; with 0 a batch needs none.
    variances : (mesh, deformation)
        Variances of the train part's latent vectors.
    """

    def __init__(
        self, network: CyclePair, weight: float, own_weight: float, variances: tuple[float, float] = (1.0, 1.0)
    ) -> None:
        super().__init__()
        self.network = network
        self.pair, self.weight, self.own_weight = network, weight, own_weight
        self.of_mesh, self.of_picture = variances

    def forward(self, batch: Batch, epoch: float) -> Losses:
        """Scalars ``loss``, ``error`` of the plain projections, ``cycle``, and ``own`` where it has a weight."""
        mesh, picture = batch["mesh"], batch["deformation"]
        forth, back = self.pair.forth(mesh), self.pair.back(picture)
        error = self._both(forth, picture, back, mesh)
        cycle = self._both(self.pair.forth(back), picture, self.pair.back(forth), mesh)
        losses = {"loss": error + self.weight * cycle, "error": error.detach(), "cycle": cycle.detach()}
        if self.own_weight:
            walks = batch[MESHES].shape[1]
            pictures, meshes = (latents.repeat_interleave(walks, dim=0) for latents in (picture, mesh))
            forth, back = (batch[name].flatten(0, 1) for name in (MESHES, PICTURES))
            own = self._both(self.pair.forth(forth), pictures, self.pair.back(back), meshes)
            losses["loss"] = losses["loss"] + self.own_weight * own
            losses["own"] = own.detach()
        return losses

    def _both(self, pictures: Tensor, true_pictures: Tensor, meshes: Tensor, true_meshes: Tensor) -> Tensor:
        """Sum of the mean squared errors of pictures' and meshes' latent vectors, each as a share of the variance."""
        of_pictures = nn.functional.mse_loss(pictures.float(), true_pictures) / self.of_picture
        return of_pictures + nn.functional.mse_loss(meshes.float(), true_meshes) / self.of_mesh


def cycle_pair(recipe_run: RecipeRun, learns_own: bool) -> CyclePair:
    """The pair of projections of a recipe, trained together; training starts from its plain projections.

    With ``learns_own`` the pair is also trained on its own outputs, decoded and encoded again.
    """
    section = recipe_run.recipe.models["cycle"]
    forth, back = recipe_run.projection("mesh_to_image", True), recipe_run.projection("image_to_mesh", True)
    keys = recipe_run.kept.keys
    parents = {vae.kind: keys[vae.kind] for vae in (recipe_run.image_vae, recipe_run.mesh_vae)}
    parents |= {name: keys[name] for name in ("projection_mesh_to_image_split", "projection_image_to_mesh_split")}

    def build() -> tuple[Objective, TensorItems, TensorItems]:
        pair = CyclePair(forth.settings, back.settings)
        pair.forth.load_state_dict(forth.state_dict())
        pair.back.load_state_dict(back.state_dict())
        train, val = (cycle_items(recipe_run, part, forth, back, learns_own) for part in ("train", "val"))
        variances = tuple(max(float(train.tensors[name].var()), 1e-12) for name in ("mesh", "deformation"))
        own_weight = section["own_weight"] if learns_own else 0.0
        objective = CycleObjective(pair, section["weight"], own_weight, (variances[0], variances[1]))
        return objective, train, val

    name = "cycle_pair_own" if learns_own else "cycle_pair"
    described = {**section, "learns_own": learns_own}
    options, fingerprint = recipe_run.recipe.training("cycle"), recipe_run.frames("train").fingerprint
    return cast("CyclePair", recipe_run.trained(name, parents, described, fingerprint, options, build))


def cycle_items(recipe_run: RecipeRun, part: str, forth: Projection, back: Projection, learns_own: bool) -> TensorItems:
    """Latent vectors of a part as items: ``mesh``, ``deformation``, and where asked for re-encoded outputs of cycles.

    Parameters
    ----------
    recipe_run : RecipeRun
    part : str
        Part of the recipe's split.
    forth, back : Projection
        Plain projections from mesh to deformation and back, which make the cycles.
    learns_own : bool
        Whether re-encoded outputs are among the items.
    """
    tensors = {name: recipe_run.latents(part, name) for name in ("mesh", "deformation")}
    if learns_own:
        base = recipe_run.latents(part, "image") - tensors["deformation"]
        tensors |= around(recipe_run, forth, back, tensors["deformation"], base)
    frames = recipe_run.frames(part)
    return TensorItems(tensors, frames.fingerprint, frames)


def around(
    recipe_run: RecipeRun, forth: Projection, back: Projection, deformation: Tensor, base: Tensor
) -> dict[str, Tensor]:
    """Latent vectors (n, cycles, d) of meshes and deformations after each of several cycles, decoded and encoded again.

    A cycle makes meshes of the pictures, and then pictures of these meshes.

    Parameters
    ----------
    recipe_run : RecipeRun
    forth, back : Projection
        From mesh to deformation, and back.
    deformation, base : (n, d)
        Latent vectors of the pictures' deformations, and of their backgrounds.

    Returns
    -------
    dict of Tensor
        ``mesh_again`` and ``deformation_again``.
    """
    walks: dict[str, list[Tensor]] = {MESHES: [], PICTURES: []}
    for cycle in range(recipe_run.recipe.models["cycle"]["walks"]):
        meshes, pictures = [], []
        for start in range(0, len(base), CHUNK):
            recipe_run.tell(start, len(base), f"cycle_pair: cycle {cycle + 1}")
            # picture to mesh and back to a picture; each is decoded and encoded again
            chunk = slice(start, start + CHUNK)
            moved = decode_displacements(recipe_run.mesh_vae, project(back, deformation[chunk]))
            meshes.append(encode_displacements(recipe_run.mesh_vae, moved))
            shown = decode_pictures(recipe_run.image_vae, project(forth, meshes[-1]) + base[chunk])
            pictures.append(encode_pictures(recipe_run.image_vae, shown) - base[chunk])
        deformation = torch.cat(pictures)
        walks[MESHES].append(torch.cat(meshes))
        walks[PICTURES].append(deformation)
    return {name: torch.stack(cycles, dim=1) for name, cycles in walks.items()}


def split_cycle(recipe_run: RecipeRun) -> LatentMeshToImage:
    """SPLIT from meshes to pictures, with projections that were trained together."""
    pair = cycle_pair(recipe_run, learns_own=True)
    return LatentMeshToImage("split_cycle", recipe_run.mesh_vae, recipe_run.image_vae, pair.forth)


def split_cycle_mesh(recipe_run: RecipeRun) -> LatentImageToMesh:
    """SPLIT from pictures to meshes, with projections that were trained together."""
    pair = cycle_pair(recipe_run, learns_own=True)
    return LatentImageToMesh("split_cycle", recipe_run.image_vae, recipe_run.mesh_vae, pair.back)
