"""Zhu et al. 2022 as a row of the tables: trained and adapted on the train part of a recipe's store."""

from __future__ import annotations

from typing import cast

from split_models.learning.items import Items
from split_models.learning.objectives import Objective
from split_models.methods.depth_rendering import DepthRenderer
from split_models.methods.optical_method import surface_of
from split_models.methods.zhu import ImprintItems, ZhuMethod, ZhuNetwork, ZhuObjective
from split_models.recipe.recipe_run import RecipeRun
from tactiledata.optics.view import View
from tactiledata.sensors.digit import DIGIT


def zhu(recipe_run: RecipeRun) -> ZhuMethod:
    """The trained network of Zhu et al. as a method, with the nominal camera."""
    section, mesh = recipe_run.recipe.models["zhu"], recipe_run.recipe.models["mesh_vae"]
    size = (int(section["size"][0]), int(section["size"][1]))

    def build() -> tuple[Objective, Items, Items]:
        mean, spread = recipe_run.vertex_scale
        network = ZhuNetwork(
            recipe_run.hierarchy, size, section["channels"], mesh["filters"], mesh["order"], mean, spread
        )
        renderer = DepthRenderer(surface_of(recipe_run), View.nominal(DIGIT, size))
        objective = ZhuObjective(network, renderer, section["adaptation_weight"], section["anneal"])
        train, val = (ImprintItems(recipe_run.frames(part), size) for part in ("train", "val"))
        return objective, train, val

    described = {**section, "filters": mesh["filters"], "order": mesh["order"]}
    options = recipe_run.recipe.training("zhu", settle=section["anneal"])
    fingerprint, topology = recipe_run.frames("train").fingerprint, recipe_run.topology.digest
    network = recipe_run.trained("zhu", {}, described, fingerprint, options, build, topology)
    return ZhuMethod(cast("ZhuNetwork", network))
