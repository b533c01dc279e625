"""What `--scale paper` costs: arithmetic, memory and time of each network, worked out from one step on a processor.

    python benchmarks/paper_cost.py [--tera 40] [--memory 20] [--json docs/results/paper-cost.json]

Each network has the paper's sizes and random weights. Steps forwards and backwards on one and on two items count its
floating point operations (convolutions and dense products; PyTorch's counter) and the bytes that it keeps for the way
back, which grow with the batch. `pieces` is the least `accumulate` with which a batch stays below `--memory` GiB in
float32, weights, gradients and both moments of Adam included. Hours are those of all epochs, of which early stopping
spares some, on the paper's 189,433 training frames at `--tera` TFLOP/s sustained.
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch.utils.flop_counter import FlopCounterMode

from split_models.learning.augment import Augmentation
from split_models.learning.objectives import ImageVaeObjective, MeshVaeObjective, Objective, Regression
from split_models.networks.end_to_end import EndToEnd
from split_models.networks.force_head import ForceHead, RawForces
from split_models.networks.image_vae import ImageVae, as_input
from split_models.networks.mesh_graph import Topology, build_hierarchy, cell_faces
from split_models.networks.mesh_vae import MeshVae
from split_models.networks.projection import Projection
from split_models.recipe.image_vae_recipe import SIZES
from split_models.recipe.recipe import Recipe, load_recipe
from tactiledata.contract.atomic import write_json_atomic
from tactiledata.gel.mesh.structured_pad import pad_mesh
from tactiledata.sensors.digit import DIGIT

FRAMES = 189_433
"""Training frames of the paper."""
GIB = 2**30
ADAM = 16
"""Bytes for each weight: itself, its gradient and two moments, float32."""

Batches = dict[str, torch.Tensor]


@dataclass(frozen=True)
class Cost:
    """What a network costs.

    Parameters
    ----------
    network : str
        Name of its section in recipes.
    weights : int
        Number of parameters.
    operations : float
        Floating point operations of one item, forwards and backwards.
    kept : float
        Bytes that one item keeps for the way back, float32.
    batch, epochs : int
        As the recipe has them.
    """

    network: str
    weights: int
    operations: float
    kept: float
    batch: int
    epochs: int

    def memory(self, pieces: int) -> float:
        """GiB of a step whose batch comes in so many pieces."""
        return (self.kept * -(-self.batch // pieces) + ADAM * self.weights) / GIB

    def pieces(self, memory: float) -> int:
        """The least number of pieces with which a step stays below a memory, GiB."""
        return next(count for count in itertools.count(1) if self.memory(count) <= memory or count >= self.batch)

    def hours(self, tera: float) -> float:
        """Hours of all epochs at a speed, TFLOP/s."""
        return self.operations * FRAMES * self.epochs / (tera * 1e12) / 3600


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tera", type=float, default=40.0, help="TFLOP/s sustained")
    parser.add_argument("--memory", type=float, default=20.0, help="GiB that a step may take")
    parser.add_argument("--json", type=Path, help="file that takes the figures as a document")
    given = parser.parse_args()
    recipe = load_recipe("split_backbone", "paper")
    heads = ("weights, millions", "GFLOP an item", "MiB kept an item", "batch", "GiB whole", "pieces", "GiB in pieces")
    print(f"| network | {' | '.join(heads)} | epochs | hours |\n|---|{'---|' * (len(heads) + 2)}")
    documents = []
    for name, section, build, item in networks(recipe):
        training = recipe.models[section]["training"]
        cost = measured(name, build, item, training["batch_size"], training["epochs"])
        pieces = cost.pieces(given.memory)
        cells = (
            f"{cost.weights / 1e6:.2f}", f"{cost.operations / 1e9:.3g}", f"{cost.kept / 2**20:.3g}", f"{cost.batch}",
            f"{cost.memory(1):.3g}", f"{pieces}", f"{cost.memory(pieces):.3g}", f"{cost.epochs}",
            f"{cost.hours(given.tera):.3g}",
        )  # fmt: skip
        print(f"| {name} | {' | '.join(cells)} |", flush=True)
        documents.append({**vars(cost), "pieces": pieces, "gib": cost.memory(pieces), "hours": cost.hours(given.tera)})
    if given.json:
        write_json_atomic(
            given.json,
            {"format": "tactiledata-figures/1", "tera": given.tera, "memory_gib": given.memory, "rows": documents},
        )


def networks(recipe: Recipe) -> list[tuple[str, str, Callable[[], Objective], Callable[[int], Batches]]]:
    """Name, section, objective and a batch of random items of each network, at a recipe's sizes."""
    mesh = pad_mesh("digit", DIGIT.gel, recipe.data["replay"]["resolution"])
    models, size = recipe.models, tuple(recipe.data["image_size"])
    image = {name: models["image_vae"][name] for name in SIZES}
    graph = {name: models["mesh_vae"][name] for name in ("filters", "order")}
    hierarchy = build_hierarchy(Topology(mesh.vertices, cell_faces(mesh.cells)), len(graph["filters"]))
    latent = models["mesh_vae"]["latent"]
    scale = {"mean": np.zeros((len(mesh.vertices), 3)), "spread": np.full((len(mesh.vertices), 3), 1e-4)}
    layers, head = models["projection"], models["force_head"]

    def felt() -> MeshVae:
        return MeshVae(hierarchy, **graph, latent=latent, **scale)

    def pictures(count: int) -> torch.Tensor:
        return torch.randint(0, 255, (count, *size, 3), dtype=torch.uint8)

    def meshes(count: int) -> torch.Tensor:
        return 1e-4 * torch.randn(count, len(mesh.vertices), 3)

    def vectors(inputs: int, outputs: int) -> Callable[[int], Batches]:
        return lambda count: {"given": torch.randn(count, inputs), "target": torch.randn(count, outputs)}

    def forces(count: int) -> torch.Tensor:
        return torch.randn(count, 3)

    still = [0.0] * 3, [1.0] * 3
    augmentation = Augmentation(**models["image_vae"]["augmentation"])
    return [
        (
            "image VAE", "image_vae",
            lambda: ImageVaeObjective(ImageVae(size, **image), 0.001, 0, augmentation),
            lambda count: {"image": pictures(count)},
        ),
        ("mesh VAE", "mesh_vae", lambda: MeshVaeObjective(felt(), 0.005), lambda count: {"mesh": meshes(count)}),
        (
            "end-to-end", "end_to_end",
            lambda: Regression(
                EndToEnd(hierarchy, graph, {"size": list(size), **image}, **scale), "mesh", "image", None, as_input
            ),
            lambda count: {"mesh": meshes(count), "image": pictures(count)},
        ),
        (
            "projection", "projection",
            lambda: Regression(
                Projection(latent, image["latent"], layers["layers"], layers["dropout"]), "given", "target"
            ),
            vectors(latent, image["latent"]),
        ),
        (
            "force head", "force_head",
            lambda: Regression(ForceHead(image["latent"], head["layers"], head["dropout"], *still), "given", "target"),
            vectors(image["latent"], 3),
        ),
        (
            "raw images", "raw_forces",
            lambda: Regression(RawForces(ImageVae(size, **image), *still), "image", "force", as_input),
            lambda count: {"image": pictures(count), "force": forces(count)},
        ),
        (
            "raw vertices", "raw_forces",
            lambda: Regression(RawForces(felt(), *still), "mesh", "force"),
            lambda count: {"mesh": meshes(count), "force": forces(count)},
        ),
    ]  # fmt: skip


def measured(
    name: str, build: Callable[[], Objective], item: Callable[[int], Batches], batch: int, epochs: int
) -> Cost:
    """The cost of a network by steps of one and of two items; their difference is what an item adds."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        objective = build().train()
        (one, _), (two, kept_of_two) = (step(objective, item(count)) for count in (1, 2))
        _, kept_of_one = step(objective, item(1))
    weights = sum(values.numel() for values in objective.parameters())
    return Cost(name, weights, two - one, kept_of_two - kept_of_one, batch, epochs)


def step(objective: Objective, batch: Batches) -> tuple[float, float]:
    """Operations of a step, and the bytes that it keeps for the way back beside the weights."""
    own = {values.untyped_storage().data_ptr() for values in (*objective.parameters(), *objective.buffers())}
    kept: dict[int, int] = {}

    def keep(values: torch.Tensor) -> torch.Tensor:
        place = values.untyped_storage()
        if place.data_ptr() not in own:
            kept[place.data_ptr()] = place.nbytes()
        return values

    counter: Any = FlopCounterMode(display=False)
    with counter, torch.autograd.graph.saved_tensors_hooks(keep, lambda values: values):
        objective(batch, 1.0)["loss"].backward()
    return float(counter.get_total_flops()), float(sum(kept.values()))


if __name__ == "__main__":
    main()
