"""From touch to picture on the processor: SPLIT against Taxim and FOTS, on the same frames in one run, step by step.

    python benchmarks/inference.py [--scale small|paper] [--touches 13] [--threads 1] [--quick]

The networks have a recipe's sizes and random weights, which take the same time as trained ones. Each method is given
the mesh of the resolution that the SPLIT paper gives it: Taxim and FOTS 80,190 vertices, SPLIT 6,105; Taxim and FOTS
have the low one, too. Memory is the peak of a process that does nothing else, Python and its libraries with it.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch
from gel_speed import MATERIAL, touches
from timing import header, table, verdict

from split_models.methods.fots import fots_published
from split_models.methods.taxim import taxim_published
from split_models.networks.image_vae import ImageVae
from split_models.networks.latent import LatentMeshToImage
from split_models.networks.mesh_graph import Topology, build_hierarchy, cell_faces
from split_models.networks.mesh_vae import MeshVae
from split_models.networks.projection import Projection
from split_models.onnx.export import PACKAGES, export_models
from split_models.onnx.models import OnnxMeshToImage, OnnxModels
from split_models.recipe.recipe import Recipe, load_recipe
from split_models.tables.inference_time import cost_rows
from split_models.tables.simulated_frames import Pad, simulate
from split_models.tables.step_race import measure_memory, time_methods, timed_methods
from tactiledata.gel.mesh.structured_pad import pad_mesh
from tactiledata.sensors.backgrounds import load_background
from tactiledata.sensors.digit import DIGIT

TARGET = 3.0
BACKGROUND = "digit-bg-0"


def networks(recipe: Recipe) -> tuple[ImageVae, MeshVae, Projection, Projection]:
    """Untrained ones of a recipe's sizes."""
    mesh, keep = pad_mesh("digit", DIGIT.gel, "low"), recipe.data["replay"]["keep"]
    faces = cell_faces(mesh.cells)
    places = mesh.vertices
    if keep == "surface":
        row_of = np.full(len(mesh.vertices), -1)
        row_of[mesh.surface] = np.arange(len(mesh.surface))
        faces = row_of[faces]
        faces, places = faces[(faces >= 0).all(axis=1)], mesh.vertices[mesh.surface]
    models = recipe.models
    sizes = {name: models["image_vae"][name] for name in ("blocks", "down", "channels", "latent")}
    image = ImageVae(recipe.data["image_size"], **sizes)
    sizes = {name: models["mesh_vae"][name] for name in ("filters", "order", "latent")}
    felt = MeshVae(build_hierarchy(Topology(places, faces), len(sizes["filters"])), **sizes)
    felt.spread.fill_(1e-4)
    layers = models["projection"]["layers"], models["projection"]["dropout"]
    forth = Projection(felt.latent, image.latent, *layers)
    back = Projection(image.latent, felt.latent, *layers)
    return image.eval(), felt.eval(), forth.eval(), back.eval()


def methods(recipe: Recipe, surface: Any, background: Any, moved: Any, folder: Path) -> dict[str, Any]:
    """What is compared; SPLIT by onnxruntime where that is installed."""
    image, felt, forth, back = networks(recipe)
    found = {
        "taxim_published": taxim_published(surface),
        "fots_published": fots_published(surface),
        "split": LatentMeshToImage("split", felt, image, forth),
    }
    if all(find_spec(name) is not None for name in PACKAGES):
        export_models(folder, image, felt, forth, back, np.stack([background, background[::-1]]), moved)
        found["split_onnx"] = OnnxMeshToImage(OnnxModels(folder, threads=torch.get_num_threads()))
    return found


def main() -> None:
    """Print a row for each method and resolution, and the ratio that the paper claims."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scale", default="small", choices=("small", "paper"))
    parser.add_argument("--touches", type=int, default=13)
    parser.add_argument("--threads", type=int, default=1, help="of PyTorch and onnxruntime")
    parser.add_argument("--quick", action="store_true", help="two touches, no memory")
    given = parser.parse_args()
    torch.set_num_threads(given.threads)
    recipe = load_recipe("table_inference_time", given.scale)
    size = (int(recipe.data["image_size"][0]), int(recipe.data["image_size"][1]))
    background = cv2.resize(load_background(BACKGROUND), size[::-1], interpolation=cv2.INTER_AREA)
    pad = Pad("digit", DIGIT.gel, MATERIAL, "finite-strain", recipe.data["replay"]["keep"])
    simulated = simulate(pad, touches(2 if given.quick else given.touches), measures_memory=not given.quick)
    low = simulated["low"]
    with tempfile.TemporaryDirectory() as folder:
        moved = np.stack(low.displacements[:2])
        timed = timed_methods(methods(recipe, low.surface, background, moved, Path(folder)))
        drawn = [(number, "DIGIT") for number in range(len(low.frames))]
        time_methods(timed, simulated, drawn, {"DIGIT": background})
        if not given.quick:
            measure_memory(timed, simulated, drawn[0], {"DIGIT": background})
    rows = cost_rows(timed, simulated)
    header(
        f"touch to picture, {size[0]} x {size[1]}, {len(low.frames)} frames, {given.threads} threads, "
        f"OMP_NUM_THREADS={os.environ.get('OMP_NUM_THREADS', 'not set')}",
        ["torch", "numpy", *(["onnxruntime"] if find_spec("onnxruntime") else [])],
    )
    names = [name for name in rows[0] if not name.startswith("times")]
    units = {name: rows[0][name]["unit"] for name in names}
    table(
        ["method", *(f"{name}, {'ms' if units[name] == 's' else units[name]}" for name in names)],
        [[one.title, *(_cell(row[name]) for name in names)] for one, row in zip(timed, rows, strict=True)],
    )
    for one, row in zip(timed, rows, strict=True):
        for resolution in ("high", "low"):
            ratio = row[f"times faster than the fastest baseline, {resolution} resolution"]
            if ratio["value"] is not None:
                verdict(
                    f"{one.title} against the faster of Taxim and FOTS at {resolution} resolution",
                    ratio["value"],
                    TARGET,
                )


def _cell(score: Any) -> str:
    if score["value"] is None:
        return ""
    return f"{1e3 * score['value']:.1f}" if score["unit"] == "s" else f"{score['value']:.0f}"


if __name__ == "__main__":
    main()
