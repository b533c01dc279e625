"""The data of a recipe: its store, made first where it is a simulated world, and the frames that networks use."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

import numpy as np

from split_models.learning.data import TouchFrames, vertex_scale
from split_models.learning.device import Ranks
from split_models.networks.mesh_graph import Hierarchy, Topology, build_hierarchy
from split_models.recipe.prepare import mesh_name, prepare_store, store_place
from split_models.recipe.recipe import Recipe
from tactiledata.contract.progress import Progress


class RecipeData:
    """The data of a recipe, each part read when it is first used.

    Parameters
    ----------
    recipe : Recipe
    out : Path
        Folder below which worlds are kept.
    ranks : Ranks
        The first process makes a missing store while the others wait.
    tell : callable
        Called with how much is done, how much there is, and words.
    workers : int
        Local processes that record, ingest and replay.
    """

    def __init__(self, recipe: Recipe, out: Path, ranks: Ranks, tell: Progress, workers: int) -> None:
        self.recipe, self.out, self.ranks, self.tell, self.workers = recipe, out, ranks, tell, workers
        self._frames: dict[str, TouchFrames] = {}

    @cached_property
    def store(self) -> Path:
        """Path of the store, ready to learn from."""
        if self.ranks.is_first:
            prepare_store(self.recipe, self.out, self.workers, self.tell)
        self.ranks.wait()
        return store_place(self.recipe, self.out)

    def frames(self, part: str) -> TouchFrames:
        """Frames of a part of the split that have a picture, a mesh, a wrench and a background."""
        if part not in self._frames:
            data = self.recipe.data
            self._frames[part] = TouchFrames(
                self.store,
                f"{data['split']['name']}/{part}",
                camera=data["camera"],
                size=data["image_size"],
                mesh=mesh_name(data),
                wrench=data["wrench"] or None,
            )
        return self._frames[part]

    @cached_property
    def topology(self) -> Topology:
        """Topology of the store's mesh."""
        return self.frames("train").topology()

    @cached_property
    def hierarchy(self) -> Hierarchy:
        """The store's mesh with its coarser levels, one for each of the mesh VAE's filters."""
        return build_hierarchy(self.topology, len(self.recipe.models["mesh_vae"]["filters"]))

    @cached_property
    def vertex_scale(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean and spread (v, 3), m, of the train part's displacements."""
        return vertex_scale(self.frames("train"))

    @cached_property
    def force_scale(self) -> tuple[list[float], list[float]]:
        """Mean and spread (3,), N, of the train part's forces; the spread is at least 1e-3 N."""
        forces = self.frames("train").forces().astype(np.float64)
        return forces.mean(axis=0).tolist(), np.maximum(forces.std(axis=0), 1e-3).tolist()

    @cached_property
    def extra_frames(self) -> list[TouchFrames]:
        """Pictures of other corpora, from which only the image VAE learns."""
        return [
            TouchFrames(
                extra["store"],
                extra.get("split", "default/train"),
                camera=extra.get("camera", self.recipe.data["camera"]),
                size=self.recipe.data["image_size"],
                background=False,
            )
            for extra in self.recipe.data["extra_stores"]
        ]
