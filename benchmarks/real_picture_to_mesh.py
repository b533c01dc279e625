"""Real pictures of contacts to meshes of the gel, by the bundled image VAE and networks of simulated touches.

    python benchmarks/real_picture_to_mesh.py [--touches 150] [--epochs 40] [--keep FOLDER]
        [--out docs/images/real-picture-to-mesh.jpg] [--json docs/results/real-picture-to-mesh.json]

A mesh VAE and the projection from the picture's latent vector to the mesh's learn on touches that the rig records on
six units and that the linear gel replays. The image VAE is the bundled one. Then two real contacts of a DIGIT and real
presses of a GelSight, on which nothing was trained, go through the same networks, beside simulated touches of a unit
that nothing was trained on.

Of a real contact nobody knows the mesh. What can be measured is where it is: the distance between the centre of what
the touch changes in the picture and the centre of the dent (weighted by the change, and by the depth), along the gel as
the nominal camera sees it. The row of the undeformed mesh's centre is the middle of the gel.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch
import yaml
from transfer_real_contacts import digit_contacts, gelsight_presses

from split_models.learning.contact_region import contact_region
from split_models.methods.methods import split_mesh
from split_models.methods.optical_method import surface_of
from split_models.networks.image_vae import ImageVae
from split_models.recipe.recipe import load_recipe
from split_models.recipe.recipe_run import RecipeRun
from split_models.tables.mesh_picture import MeshPictures
from split_models.transfer.latent_transfer import load_image_vae
from split_models.transfer.methods import BUNDLED_MODEL
from split_models.transfer.picture_size import scaled
from tactiledata.contract.atomic import write_json_atomic
from tactiledata.metrics.mesh_distance import rmse
from tactiledata.optics.height_map import Indentation
from tactiledata.optics.view import View
from tactiledata.sensors.digit import DIGIT

UNITS = {f"K{number}": f"digit-bg-{number}" for number in (2, 3, 4, 6, 9, 11)}
"""Units to learn from: those whose light the bundled model knows."""
UNSEEN = {"N1": "digit-bg-1", "N16": "digit-bg-16"}
"""Units that nothing learns from."""
SHAPES = ("sphere", "dome", "torus", "cone", "edge", "cylinder_side", "cylinder_flat", "box", "hexagon", "dots")
FORCE = (1.0, 13.0)
PRESSES = (5, 21, 35)
SHOWN = 3


class BundledRun(RecipeRun):
    """A run of a recipe whose image VAE is the bundled one."""

    @property
    def image_vae(self) -> ImageVae:
        """The bundled image VAE."""
        if "image_vae" not in self.kept.keys:
            self.bundled, self.kept.keys["image_vae"], _ = load_image_vae(BUNDLED_MODEL)
        return self.bundled


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--touches", type=int, default=150)
    parser.add_argument("--epochs", type=int, default=40, help="of the mesh VAE")
    parser.add_argument("--keep", type=Path, help="folder for the world and the models [default: none is kept]")
    parser.add_argument("--contacts", type=Path, default=Path("tests/data/digit_contact"))
    parser.add_argument("--pack", type=Path, default=Path("tests/data/gelsight_r15/dataPack.npz"))
    parser.add_argument("--out", type=Path, default=Path("docs/images/real-picture-to-mesh.jpg"))
    parser.add_argument("--json", type=Path, help="file that takes the figures as a document")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        run = opened(given.keep or Path(scratch), given.touches, given.epochs)
        method, size = split_mesh(run), run.image_vae.size
        surface = surface_of(run)
        unseen = run.frames("test_unseen")
        digit, untouched = digit_contacts(given.contacts)
        presses, flat = gelsight_presses(given.pack)
        cases = [(f"real DIGIT contact {n + 1}", picture, untouched) for n, picture in enumerate(digit)]
        cases += [(f"real GelSight press {n}", presses[n], flat) for n in PRESSES]
        real = [(title, scaled(one[None], size)[0], scaled(bare[None], size)[0]) for title, one, bare in cases]
        rows = [
            measured(title, picture, bare, method.predict(picture[None], bare)[0], surface)
            for title, picture, bare in real
        ]
        shown = [(*case, row.pop("mesh"), None) for case, row in zip(real, rows, strict=True)]
        chosen = np.linspace(0, len(unseen) - 1, 40).astype(int)
        predicted = {
            int(n): method.predict(unseen.pictures([n]), unseen.background(unseen.sensors[n]))[0] for n in chosen
        }
        simulated = [
            measured("", unseen.pictures([n])[0], unseen.background(unseen.sensors[n]), mesh, surface)
            for n, mesh in predicted.items()
        ]
        true = {n: unseen.displacements([n]) for n in predicted}
        errors = [float(rmse(predicted[n][None], true[n])[0]) for n in predicted]
        at_rest = [float(rmse(np.zeros_like(true[n]), true[n])[0]) for n in predicted]
        for n in list(predicted)[:: len(predicted) // SHOWN][:SHOWN]:
            title = f"simulated, {unseen.indenters[n]} on {unseen.sensors[n]}"
            shown.append(
                (title, unseen.pictures([n])[0], unseen.background(unseen.sensors[n]), predicted[n], true[n][0])
            )
        draw(shown, surface, size, given.out)
    print(
        "| contact | dent, mm deep | centre of the dent from that of the change, mm | middle of the gel from it, mm |"
    )
    print("|---|---|---|---|")
    for row in rows:
        print(f"| {row['contact']} | {row['depth_mm']:.2f} | {row['apart_mm']:.2f} | {row['middle_apart_mm']:.2f} |")
    apart, middle = (np.array([one[name] for one in simulated]) for name in ("apart_mm", "middle_apart_mm"))
    words = f"{len(simulated)} simulated touches of unseen units, median"
    print(f"| {words} | – | {np.nanmedian(apart):.2f} | {np.nanmedian(middle):.2f} |")
    print(f"\nmeshes of these: RMSE {np.mean(errors):.4f} mm, of the undeformed mesh {np.mean(at_rest):.4f} mm")
    print(f"{given.out}: {given.out.stat().st_size / 1e3:.0f} kB")
    if given.json:
        own = {"rmse_mm": float(np.mean(errors)), "rmse_at_rest_mm": float(np.mean(at_rest))}
        own |= {"apart_mm": float(np.nanmedian(apart)), "middle_apart_mm": float(np.nanmedian(middle))}
        write_json_atomic(given.json, {"format": "tactiledata-figures/1", "real": rows, "simulated_unseen": own})


def opened(home: Path, touches: int, epochs: int) -> BundledRun:
    """The run of a recipe on a world of known and unseen units, without an image VAE of its own."""
    home.mkdir(parents=True, exist_ok=True)
    units = {**UNITS, **UNSEEN}
    world = {
        "format": "tactiledata-scenario/1",
        "title": "real pictures to meshes",
        "seed": 404,
        "sensors": {unit: {"background": background} for unit, background in units.items()},
        "indenters": {name: {"shape": name} for name in SHAPES},
        "streams": {"joints": 125, "tcp": 125, "wrench": 100},
        "recordings": {"group": "sensor"},
        "generate": {"count": touches, "depth": [0.0005, 0.0012], "tilt": [0.0, 0.12], "shear_share": 0.3},
    }
    (home / "world.yaml").write_text(yaml.safe_dump(world), encoding="utf-8")
    recipe = {
        "format": "tactiledata-recipe/1",
        "title": "real pictures to meshes",
        "data": {
            "world": str(home / "world.yaml"),
            "image_size": [160, 120],
            "replay": {"fidelity": "linear", "keep": "surface", "material": "planted"},
            "split": {
                "by": ["trajectory", "sensor"], "hold_out": {"sensor": list(UNSEEN)}, "fractions": [0.85, 0.15, 0.0],
                "force": list(FORCE),
            },
        },
        "models": {
            "mesh_vae": {"training": {"epochs": epochs, "batch_size": 32, "patience": 10}},
            "projection": {"training": {"epochs": 150, "batch_size": 128, "patience": 30}},
        },
    }  # fmt: skip
    (home / "recipe.yaml").write_text(yaml.safe_dump(recipe), encoding="utf-8")

    def tell(done: int, total: int, what: str = "") -> None:
        print(f"{done} of {total}: {what}", end="\r", flush=True)

    return BundledRun(load_recipe(home / "recipe.yaml"), home, torch.device("cpu"), tell=tell)


def measured(title: str, picture: np.ndarray, background: np.ndarray, mesh: np.ndarray, surface: Any) -> dict[str, Any]:
    """Depth and place of a dent, and how far that is from what the touch changes in the picture, mm along the gel."""
    view = View.nominal(DIGIT, picture.shape[:2])
    change = np.abs(picture.astype(np.float32) - background).max(axis=2)
    change = np.where(contact_region(picture[None], background)[0], change, 0.0)
    depth = Indentation(surface, view).of(mesh).clip(0)
    depth = np.where(depth > 0.5 * depth.max(), depth, 0.0)
    points = view.points()
    seen, dent = (centre(weights, points) for weights in (change, depth))
    return {
        "contact": title,
        "depth_mm": 1e3 * float(depth.max()),
        "apart_mm": 1e3 * float(np.linalg.norm(dent - seen)),
        "middle_apart_mm": 1e3 * float(np.linalg.norm(seen)),
        "mesh": mesh,
    }


def centre(weights: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Mean (2,), m, of points (h, w, 2) with weights (h, w); NaN where all weights are 0."""
    total = weights.sum()
    return (weights[..., None] * points).sum(axis=(0, 1)) / total if total > 0 else np.full(2, np.nan)


def draw(shown: list[Any], surface: Any, size: tuple[int, int], out: Path) -> None:
    """Write the picture: each contact without contact, as recorded, its mesh, and where it is known the true mesh."""
    rows, gap = [], 4
    for title, picture, bare, mesh, true in shown:
        deepest = float(-(mesh if true is None else true)[:, 2].min())
        drawn = MeshPictures(surface, size, deepest)
        cells = [bare, picture, drawn.draw(mesh), np.full_like(picture, 255) if true is None else drawn.draw(true)]
        framed = [cv2.copyMakeBorder(one, 0, gap, gap, gap, cv2.BORDER_CONSTANT, value=(255,) * 3) for one in cells]
        line = np.hstack(framed)
        caption = np.full((18, line.shape[1], 3), 255, np.uint8)
        cv2.putText(caption, title, (gap, 13), cv2.FONT_HERSHEY_SIMPLEX, 0.42, (0, 0, 0), 1, cv2.LINE_AA)
        rows.append(np.vstack([caption, line]))
    half = -(-len(rows) // 2)
    rows += [np.full_like(rows[0], 255)] * (2 * half - len(rows))
    sheet = np.hstack([np.vstack(rows[:half]), np.vstack(rows[half:])])
    words = "without contact | touch | mesh by SPLIT | mesh of the replay, where it is known"
    head = np.full((22, sheet.shape[1], 3), 255, np.uint8)
    cv2.putText(head, words, (gap, 15), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (0, 0, 0), 1, cv2.LINE_AA)
    out.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(out), np.vstack([head, sheet])[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 90])


if __name__ == "__main__":
    main()
