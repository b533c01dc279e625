"""Two steps of every network at the paper's sizes on a device, and how far its results are from the CPU's.

    python benchmarks/paper_networks.py [--device cuda] [--store STORE] [--split default] [--json FILE] [--quick]

STORE has a split and one replay, best of a few hundred frames; without it a small world is recorded and replayed.

- networks: two steps of each with the paper's sizes and batches, out of few frames that are taken again and again;
  seconds of both steps, the peak of the device's memory, and the largest difference between what the network gives on
  the device and on the CPU, without bfloat16, beside the spread of what it gives
- transfer: one sensor's touches by the image VAE that comes with the toolkit, on the device and on the CPU; the
  difference of the pictures in grey levels

With `--quick`, networks and pictures are small.
"""

from __future__ import annotations

import argparse
import copy
import platform
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import torch

from split_models.learning.device import DEVICES, find_device
from split_models.learning.items import Batch, Items
from split_models.learning.train import _Loop
from split_models.methods.cycle import cycle_pair
from split_models.methods.zhu import imprints_of
from split_models.methods.zhu_row import zhu
from split_models.networks.image_vae import as_input
from split_models.networks.network import Network
from split_models.recipe.recipe import laid_over, load_recipe
from split_models.recipe.recipe_run import RecipeRun
from split_models.transfer.methods import transfer_method
from split_models.transfer.transfer_store import transfer_store
from tactiledata.contract.atomic import write_json_atomic
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.ingest.pipeline import ingest
from tactiledata.replay.attach import replay
from tactiledata.replay.options import ReplayOptions
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.splits.make import make_split
from tactiledata.store.read.reader import Store
from tactiledata.store.read.targets import find_target

STEPS, COMPARED = 2, 4
"""Steps of each network, and frames whose results on the device and on the CPU are compared."""
WORLD = {
    "format": "tactiledata-scenario/1",
    "seed": 7,
    "sensors": {"D1": {"background": "digit-bg-9"}, "D2": {"background": "digit-bg-12"}},
    "indenters": {"ball": {"shape": "sphere"}, "cross": {"shape": "cross"}},
    "streams": {"joints": 100, "tcp": 100, "wrench": 100},
    "recordings": {"group": "sensor"},
    "generate": {"count": 6, "depth": [0.0006, 0.0009], "dwell": [0.1, 0.2], "shear_share": 0.5},
}
FORCE = (0.3, 13.0)
MATERIAL = GelMaterial(0.88e6, 0.48, 0.72)
COARSE = GridPlan(5, 6, 1.2e-3, (4.8e-3, 6.0e-3), (0.0, 0.6, 1.0))
"""Pad of `--quick`."""
QUICK: dict[str, Any] = {
    "image_vae": {"blocks": [1, 1, 1], "down": [2, 5], "channels": [8, 8, 16], "training": {"batch_size": 8}},
    "mesh_vae": {"filters": [4, 4, 4, 8], "order": 3, "latent": 16, "training": {"batch_size": 8}},
    "end_to_end": {"training": {"batch_size": 8}},
    "zhu": {"training": {"batch_size": 8}},
    "raw_forces": {"training": {"batch_size": 16}},
    **{name: {"training": {"batch_size": 32}} for name in ("projection", "force_head", "cycle")},
}
QUICK_SIZE = [40, 30]
METHODS = ("latent", "latent-on-background")
TARGET = "ycb-sensorA"
HEADS = (
    "network", "batch", "pieces", "weights, millions", "seconds a step: first, second", "GiB at most",
    "largest difference to the CPU / spread",
)  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--device", choices=DEVICES, default="cpu")
    parser.add_argument("--store", type=Path, help="a store with a split and a replay")
    parser.add_argument("--split", default="default", help="its split")
    parser.add_argument("--json", type=Path, help="file that takes the figures as a document")
    parser.add_argument("--quick", action="store_true", help="small networks, to see that it runs")
    given = parser.parse_args()
    device = find_device(given.device)
    document: dict[str, Any] = {"format": "tactiledata-figures/1", "machine": machine(device), "quick": given.quick}
    with tempfile.TemporaryDirectory() as scratch:
        home = Path(scratch)
        place = (given.store or small_store(home, given.quick)).resolve()
        run = recipe_run(place, given.split, home / "networks", device, given.quick)
        document["frames"] = {part: len(run.frames(part)) for part in ("train", "val")}
        document["vertices"] = run.topology.n_vertices
        print(document["machine"], document["frames"], f"{document['vertices']} vertices")
        print(f"\n| {' | '.join(HEADS)} |\n|{'---|' * len(HEADS)}", flush=True)
        document["networks"] = {}
        for name, made in networks(run).items():
            document["networks"][name] = facts = stepped(run, name, made)
            print(row(name, facts), flush=True)
        print("\n| transfer | pictures | largest difference, grey levels | mean difference |\n|---|---|---|---|")
        document["transfer"] = {}
        for method in METHODS:
            document["transfer"][method] = facts = transferred(place, run, method, home)
            cells = (facts["pictures"], facts["largest difference"], f"{facts['mean difference']:.2g}")
            print(f"| {method} | {' | '.join(map(str, cells))} |", flush=True)
    if given.json:
        write_json_atomic(given.json, document)


def small_store(home: Path, is_quick: bool) -> Path:
    """Six touches, replayed by the linear gel; a seed is sought with which a split of so few fills both parts."""
    place = home / "ds.zarr"
    ingest(record(load_scenario(WORLD), home / "recordings", "folder"), place)
    options = ReplayOptions(MATERIAL, fidelity="linear")
    if is_quick:
        options = replace(options, keep="surface", make_pad=lambda name, gel: structured_pad(name, gel, COARSE))
    replay(place, options)
    for seed in range(200):
        split = make_split(
            Store.open(place), by="trajectory", hold_out="none", fractions=(0.5, 0.5, 0.0), force=FORCE, seed=seed,
            replace=True,
        )  # fmt: skip
        if min(split.counts[part].trajectories for part in ("train", "val")) > 1:
            return place
    raise SystemExit("no seed of 200 fills both parts of the split")


def recipe_run(place: Path, split: str, out: Path, device: torch.device, is_quick: bool) -> Repeated:
    """A run of `split_backbone` at the paper's scale on a store, of one epoch of two steps each."""
    recipe = load_recipe("split_backbone", "paper")
    sections = [name for name, section in recipe.models.items() if isinstance(section, dict)]
    models: dict[str, Any] = {name: {"training": {"epochs": 1, "patience": 0}} for name in sections}
    # backgrounds would be items beside the frames, and two steps then no two whole batches
    models["image_vae"]["background_copies"] = 0
    data: dict[str, Any] = {"store": str(place), "world": None, "split": {"name": split, "make": False}}
    if is_quick:
        models, data["image_size"] = laid_over(models, QUICK), QUICK_SIZE
    document = laid_over(recipe.document, {"data": data, "models": models})
    return Repeated(replace(recipe, document=document), out, device)


class Repeated(RecipeRun):
    """A run of a recipe whose items are taken again and again, as many as two batches have."""

    def trained(
        self, name: str, parents: Any, section: Any, fingerprint: str, options: Any, build: Any, topology: str = ""
    ) -> Network:
        """A network that took its steps; see `RecipeRun.trained`."""

        def again() -> Any:
            objective, items, validation = build()
            return objective, Again(items, STEPS * options.batch_size), validation

        return super().trained(name, parents, section, fingerprint, options, again, topology)


class Again:
    """So many items, which are others taken again and again."""

    def __init__(self, items: Items, count: int) -> None:
        self.items, self.count = items, count
        self.fingerprint = f"{items.fingerprint}-{count}"

    def __len__(self) -> int:
        return self.count

    def batch(self, numbers: Sequence[int]) -> Batch:
        """The batch of the items that stand for these numbers."""
        return self.items.batch([number % len(self.items) for number in numbers])

    def where(self, number: int) -> str:
        """Source of the item that stands for a number."""
        return self.items.where(number % len(self.items))


def networks(run: RecipeRun) -> dict[str, Callable[[], Any]]:
    """What trains each network, by name; later ones are given what earlier ones are."""
    return {
        "image_vae": lambda: run.image_vae,
        "mesh_vae": lambda: run.mesh_vae,
        "end_to_end": lambda: run.end_to_end,
        "projection_mesh_to_image_split": lambda: run.projection("mesh_to_image", True),
        "projection_mesh_to_image_nosplit": lambda: run.projection("mesh_to_image", False),
        "projection_image_to_mesh_split": lambda: run.projection("image_to_mesh", True),
        "projection_image_to_mesh_nosplit": lambda: run.projection("image_to_mesh", False),
        "force_head_deformation": lambda: run.force_head("deformation", 0),
        "raw_forces_mesh": lambda: run.raw_forces("mesh", 0),
        "raw_forces_image": lambda: run.raw_forces("image", 0),
        "cycle_pair_own": lambda: cycle_pair(run, learns_own=True),
        "zhu": lambda: zhu(run),
    }


def stepped(run: RecipeRun, name: str, made: Callable[[], Any]) -> dict[str, Any]:
    """Figures of a network's steps, and how far what it then gives is from what it gives on the CPU."""
    seconds: list[float] = []
    step, is_gpu = _Loop._step, run.device.type == "cuda"
    wait = torch.cuda.synchronize if is_gpu else lambda: None

    def timed(loop: _Loop, *batch: Any) -> None:
        wait()
        began = time.perf_counter()
        step(loop, *batch)
        wait()
        seconds.append(time.perf_counter() - began)

    if is_gpu:
        torch.cuda.empty_cache()
        torch.cuda.reset_peak_memory_stats()
    with patch.object(_Loop, "_step", timed):
        network = made()
    network = getattr(network, "network", network)  # `zhu` gives the method's row
    # names of networks begin with that of their section in the recipe
    training = next(section["training"] for key, section in run.recipe.models.items() if name.startswith(key))
    return {
        "batch": training["batch_size"],
        "pieces": training["accumulate"],
        "weights": sum(values.numel() for values in network.parameters()),
        "step_seconds": [round(value, 4) for value in seconds],
        "peak_gib": round(torch.cuda.max_memory_allocated() / 2**30, 3) if is_gpu else None,
        "differs": differences(run, name, network),
    }


def differences(run: RecipeRun, name: str, network: Any) -> dict[str, dict[str, float]]:
    """Largest difference between what a network gives on its device and on the CPU, and the spread on the CPU."""
    given = inputs(run, name, network)
    network = getattr(network, "forth", network).eval()  # of a pair of networks, the first
    with torch.no_grad():
        there, here = network(given.to(run.device)), copy.deepcopy(network).cpu()(given)
    pairs = [(there, here)] if torch.is_tensor(there) else zip(there, here, strict=True)
    return {
        what: {
            "largest": float((on_device.cpu().float() - on_cpu.float()).abs().max()),
            "spread": float(on_cpu.float().std()),
        }
        for what, (on_device, on_cpu) in zip(("output", "mean", "log_variance"), pairs, strict=False)
    }


def inputs(run: RecipeRun, name: str, network: Any) -> torch.Tensor:
    """What a network is given of the first frames of the val part."""
    frames = run.frames("val")
    few = list(range(min(COMPARED, len(frames))))
    if name == "zhu":
        return imprints_of(frames.pictures(few[:1]), frames.background(frames.sensors[0]), network.size)
    if name in ("image_vae", "raw_forces_image"):
        return as_input(torch.from_numpy(frames.pictures(few)))
    if name in ("mesh_vae", "end_to_end", "raw_forces_mesh"):
        return torch.from_numpy(frames.displacements(few))
    if name == "cycle_pair_own" or "mesh_to_image" in name:
        return run.latents("val", "mesh")[few]
    return run.latents("val", "image" if name.endswith("nosplit") else "deformation")[few]


def row(name: str, facts: Mapping[str, Any]) -> str:
    """The table's row of a network."""
    apart = "; ".join(f"{what} {one['largest']:.2g} / {one['spread']:.2g}" for what, one in facts["differs"].items())
    cells = (
        name, facts["batch"], facts["pieces"], f"{facts['weights'] / 1e6:.2f}",
        ", ".join(map(str, facts["step_seconds"])), "–" if facts["peak_gib"] is None else facts["peak_gib"], apart,
    )  # fmt: skip
    return f"| {' | '.join(map(str, cells))} |"


def transferred(place: Path, run: RecipeRun, method: str, home: Path) -> dict[str, Any]:
    """How far apart the pictures of a transfer on the device and on the CPU are, of the sensor with fewest frames."""
    store, counts = Store.open(place), Counter(run.frames("train").sensors.tolist())
    sensor = min(sorted(counts), key=lambda name: counts[name])
    pictures = []
    for turn, device in enumerate((run.device.type, "cpu")):
        out = home / f"{method}-{turn}.zarr"
        transfer_store(store, find_target(TARGET, store), transfer_method(method, None, device), out, [sensor])
        made = Store.open(out)
        pictures.append(np.asarray(made.images(np.arange(made.n_frames))).astype(np.int16))
    apart = np.abs(pictures[0] - pictures[1])
    return {"sensor": sensor, "pictures": len(apart), "largest difference": int(apart.max()),
            "mean difference": float(apart.mean())}  # fmt: skip


def machine(device: torch.device) -> dict[str, str]:
    """Versions, and the name of the GPU."""
    name = torch.cuda.get_device_name(device) if device.type == "cuda" else "none"
    return {"torch": torch.__version__, "python": platform.python_version(), "gpu": name}


if __name__ == "__main__":
    main()
