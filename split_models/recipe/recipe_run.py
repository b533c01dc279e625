"""The networks of a recipe, each trained once; recipes share a network when they describe it alike."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, cast

import torch
from torch import Tensor

from split_models.learning.checkpoint import TrainedOn
from split_models.learning.device import Ranks
from split_models.learning.items import FrameItems, Items, PictureItems, TensorItems
from split_models.learning.objectives import MeshVaeObjective, Objective, Regression, scaled_forces
from split_models.learning.train_options import TrainOptions
from split_models.networks.end_to_end import EndToEnd
from split_models.networks.force_head import ForceHead, RawForces
from split_models.networks.image_vae import ImageVae, as_input
from split_models.networks.latent_normal import drawn_alike
from split_models.networks.mesh_vae import MeshVae
from split_models.networks.network import Network
from split_models.networks.projection import Projection
from split_models.recipe.image_vae_recipe import SIZES, image_vae_objective
from split_models.recipe.kept_models import Build, KeptModels
from split_models.recipe.part_latents import part_latents
from split_models.recipe.recipe import Recipe
from split_models.recipe.recipe_data import RecipeData
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.contract.provenance import digest_of

Direction = Literal["mesh_to_image", "image_to_mesh"]
MODELS = "models"
"""Folder of the trained networks below ``out``."""


class RecipeRun(RecipeData):
    """One run of a recipe: its data, networks and latent vectors, made when they are first used and kept in ``out``.

    Parameters
    ----------
    recipe : Recipe
    out : Path
        Folder for ``data/``, ``models/`` and the tables.
    device : torch.device
        Device that networks run on.
    ranks : Ranks, optional
        Number of this process among those that train together.
    tell : callable, optional
        Called with how much is done, how much there is, and words.
    workers : int
        Local processes that record, ingest and replay.
    may_train : bool
        Whether a network that is not trained yet is trained; else it is an error.
    """

    def __init__(
        self,
        recipe: Recipe,
        out: Path,
        device: torch.device,
        ranks: Ranks | None = None,
        tell: Progress | None = None,
        workers: int = 1,
        may_train: bool = True,
    ) -> None:
        super().__init__(recipe, out, ranks or Ranks(), tell or (no_progress), workers)
        self.device = device
        self.kept = KeptModels(out / MODELS, device, self.ranks, self.tell, may_train)
        self._latents: dict[str, Tensor] = {}
        self._variants: dict[str, RecipeRun] = {}
        self._base_run: RecipeRun | None = None

    def variant(self, name: str) -> RecipeRun:
        """The run of a recipe variant, sharing networks that the variant does not change; an empty name returns self.

        Raises
        ------
        UnknownName
            The recipe has no such variant.
        """
        if not name:
            return self
        if name not in self._variants:
            recipe = self.recipe.variant(name)
            other = RecipeRun(recipe, self.out, self.device, self.ranks, self.tell, self.workers, self.kept.may_train)
            other._frames, other._base_run = self._frames, self
            self._variants[name] = other
        return self._variants[name]

    @property
    def tables(self) -> Path:
        """Folder of the recipe's table and pictures."""
        return self.out / self.recipe.name / self.recipe.scale

    # -- models ------------------------------------------------------------------------------------------------------

    @property
    def image_vae(self) -> ImageVae:
        """The trained image beta-VAE; a variant may continue from the base recipe's weights."""
        section = self.recipe.models["image_vae"]
        base = self._base_run if section["learns_on"] else None
        start, parents = (base.image_vae, base.key_of("image_vae")) if base is not None else (None, {})

        def build() -> tuple[Objective, Items, Items]:
            train, val = self.frames("train"), self.frames("val")
            items = PictureItems([train, *self.extra_frames], section["background_copies"])
            objective = image_vae_objective(section, train, start, self.extra_frames)
            return objective, items, PictureItems([val], 0, train.sensor_names)

        fingerprint = digest_of([frames.fingerprint for frames in [self.frames("train"), *self.extra_frames]])
        options = self.recipe.training("image_vae", settle=section["anneal"])
        return cast("ImageVae", self.trained("image_vae", parents, section, fingerprint, options, build))

    @property
    def mesh_vae(self) -> MeshVae:
        """The trained mesh beta-VAE."""
        section = self.recipe.models["mesh_vae"]
        sizes = {name: section[name] for name in ("filters", "order", "latent")}

        def build() -> tuple[Objective, Items, Items]:
            vae = MeshVae(self.hierarchy, **sizes, mean=self.vertex_scale[0], spread=self.vertex_scale[1])
            objective = MeshVaeObjective(vae, section["divergence_weight"])
            return objective, self._items("train", "mesh"), self._items("val", "mesh")

        fingerprint = self.frames("train").fingerprint
        options = self.recipe.training("mesh_vae")
        return cast("MeshVae", self.trained("mesh_vae", {}, section, fingerprint, options, build, self.topology.digest))

    @property
    def end_to_end(self) -> EndToEnd:
        """The trained end-to-end network from meshes to pictures."""
        models = self.recipe.models
        mesh = {name: models["mesh_vae"][name] for name in ("filters", "order")}
        image = {name: models["image_vae"][name] for name in SIZES}
        section = {"mesh": mesh, "image": {"size": self.recipe.data["image_size"], **image}}

        def build() -> tuple[Objective, Items, Items]:
            mean, spread = self.vertex_scale
            objective = Regression(
                EndToEnd(self.hierarchy, **section, mean=mean, spread=spread), "mesh", "image", None, as_input
            )
            return objective, self._items("train", "mesh", "image"), self._items("val", "mesh", "image")

        fingerprint, options = self.frames("train").fingerprint, self.recipe.training("end_to_end")
        return cast(
            "EndToEnd", self.trained("end_to_end", {}, section, fingerprint, options, build, self.topology.digest)
        )

    def projection(self, direction: Direction, is_split: bool) -> Projection:
        """The trained network between the latent spaces.

        Parameters
        ----------
        direction : "mesh_to_image" or "image_to_mesh"
        is_split : bool
            Whether the picture's side is the deformation's vector (SPLIT) or the whole picture's (NOSPLIT).
        """
        section = self.recipe.models["projection"]
        image = "deformation" if is_split else "image"
        given, target = ("mesh", image) if direction == "mesh_to_image" else (image, "mesh")
        name = f"projection_{direction}_{'split' if is_split else 'nosplit'}"

        def build() -> tuple[Objective, Items, Items]:
            sizes = {"mesh": self.mesh_vae.latent, image: self.image_vae.latent}
            network = Projection(sizes[given], sizes[target], section["layers"], section["dropout"])
            objective = Regression(network, "given", "target")
            return objective, self._latent_items("train", given, target), self._latent_items("val", given, target)

        described = {"direction": direction, "is_split": is_split, **section}
        return cast(
            "Projection",
            self.trained(
                name,
                self._vaes(),
                described,
                self.frames("train").fingerprint,
                self.recipe.training("projection"),
                build,
            ),
        )

    def force_head(self, given: str, seed: int) -> ForceHead:
        """The trained network from latent vectors to forces.

        Parameters
        ----------
        given : "mesh", "image", "deformation", "projected_nosplit" or "projected_split"
            Latent vectors that it takes; see `part_latents`.
        seed : int
            Seed of its weights and of the order of items.
        """
        section = self.recipe.models["force_head"]

        def build() -> tuple[Objective, Items, Items]:
            inputs = self.latents("train", given).shape[1]
            head = ForceHead(inputs, section["layers"], section["dropout"], *self.force_scale)
            objective = Regression(head, "given", "target", None, scaled_forces(*self.force_scale))
            return objective, self._latent_items("train", given, "force"), self._latent_items("val", given, "force")

        parents = {**self._vaes(), **self._projections_of(given)}
        options = self.recipe.training("force_head", seed)
        name, described = f"force_head_{given}_{seed}", {"given": given, **section}
        return cast(
            "ForceHead", self.trained(name, parents, described, self.frames("train").fingerprint, options, build)
        )

    def raw_forces(self, given: Literal["mesh", "image"], seed: int) -> RawForces:
        """The trained network from meshes or pictures to forces, made of the VAE's encoder, which is fine-tuned."""
        vae = self.mesh_vae if given == "mesh" else self.image_vae
        prepare = as_input if given == "image" else None

        def build() -> tuple[Objective, Items, Items]:
            network = RawForces(copy.deepcopy(vae), *self.force_scale)
            objective = Regression(network, given, "force", prepare, scaled_forces(*self.force_scale))
            return objective, self._items("train", given, "force"), self._items("val", given, "force")

        options = self.recipe.training("raw_forces", seed)
        parents = {vae.kind: self.kept.keys[vae.kind]}
        return cast(
            "RawForces",
            self.trained(
                f"raw_forces_{given}_{seed}",
                parents,
                {"given": given},
                self.frames("train").fingerprint,
                options,
                build,
                vae.topology,
            ),
        )

    def train_backbone(self) -> None:
        """Train what all tables share: both VAEs and the projections with arithmetic, for every variant as well."""
        self._vaes()
        self.projection("mesh_to_image", True)
        self.projection("image_to_mesh", True)
        for name in self.recipe.document["variants"]:
            self.variant(name).train_backbone()

    # -- latent vectors ----------------------------------------------------------------------------------------------

    def latents(self, part: str, kind: str) -> Tensor:
        """Latent vectors (n, d) of the frames of a part, kept in memory; for the kinds see `part_latents`."""
        key = f"{part}/{kind}"
        if key not in self._latents:
            with drawn_alike(self.recipe.seed):
                self._latents[key] = part_latents(self, part, kind)
        return self._latents[key]

    # -- training ----------------------------------------------------------------------------------------------------

    def _items(self, part: str, *what: str) -> FrameItems:
        """Meshes, pictures or forces of a part's frames as items."""
        return FrameItems(self.frames(part), what)

    def _latent_items(self, part: str, given: str, target: str) -> TensorItems:
        """Latent vectors or forces of a part as items with ``given`` and ``target``."""
        frames = self.frames(part)
        tensors = {"given": self.latents(part, given), "target": self.latents(part, target)}
        return TensorItems(tensors, frames.fingerprint, frames)

    def key_of(self, model: str) -> dict[str, str]:
        """Digest of what shaped a network that was requested, by the network's name."""
        return {model: self.kept.keys[model]}

    def _vaes(self) -> dict[str, str]:
        """Digests of what shaped both VAEs, which are trained if necessary."""
        return {**self.key_of(self.image_vae.kind), **self.key_of(self.mesh_vae.kind)}

    def _projections_of(self, given: str) -> dict[str, str]:
        """Digest of the projection that projected latent vectors come from; empty for other vectors."""
        if not given.startswith("projected"):
            return {}
        is_split = given == "projected_split"
        self.projection("image_to_mesh", is_split)
        name = f"projection_image_to_mesh_{'split' if is_split else 'nosplit'}"
        return {name: self.kept.keys[name]}

    def trained(
        self,
        name: str,
        parents: Mapping[str, str],
        section: Mapping[str, Any],
        fingerprint: str,
        options: TrainOptions,
        build: Build,
        topology: str = "",
    ) -> Network:
        """A network trained on the train part: from memory, from disk, or trained now.

        Parameters
        ----------
        name : str
            Name of the network in this recipe.
        parents : dict
            Digests of the networks that it is made with, by name.
        section : dict
            Values of the recipe that shape it.
        fingerprint : str
            Digest of its items.
        options : TrainOptions
        build : callable
            Gives the objective, the items and the items to validate on; called only where there is something to train.
        topology : str
            Digest of the mesh; empty where the network is for none.
        """
        described = {
            "data": self.recipe.data,
            "latents": self.recipe.models["latents"] if parents else "",
            "section": {inner: value for inner, value in section.items() if inner != "training"},
            "parents": dict(parents),
        }
        stamps = TrainedOn("", self.frames("train").split_digest, fingerprint, topology)
        return self.kept.trained(name, described, stamps, options, build)
