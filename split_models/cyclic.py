"""Picture to mesh to picture, again and again: how far it drifts from its beginning, and from cycle to cycle."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from split_models.data import TouchFrames
from split_models.latent import LatentImageToMesh, LatentMeshToImage, Latents
from split_models.picture_grid import write_grid
from split_models.workshop import Workshop
from tactiledata.errors import UnknownName
from tactiledata.metrics.image_similarity import ssim
from tactiledata.metrics.mesh_distance import rmse

VARIANTS: dict[str, Latents] = {"split": "mean", "split_sampled": "sample"}
"""Rows: by the means of the latent distributions, and by draws, as in the paper."""
STRIP = 5
"""Cycles that the strip shows."""


@dataclass(frozen=True)
class Cycle:
    """What one cycle gave: meshes of the pictures before it, and pictures of these meshes."""

    displacements: NDArray[np.float32]
    pictures: NDArray[np.uint8]


def cycles(
    forth: LatentMeshToImage,
    back: LatentImageToMesh,
    pictures: NDArray[np.uint8],
    background: NDArray[np.uint8],
    count: int,
) -> Iterator[Cycle]:
    """So many cycles from pictures (n, h, w, 3) of a sensor with a background (h, w, 3)."""
    for _ in range(count):
        displacements = back.predict(pictures, background)
        pictures = forth.predict(displacements, background)
        yield Cycle(displacements, pictures)


def cycle_values(
    forth: LatentMeshToImage, back: LatentImageToMesh, frames: TouchFrames, numbers: NDArray[np.int64], count: int
) -> dict[str, NDArray[np.float64]]:
    """Scores (frames, cycles).

    ``ssim`` and ``rmse`` (mm) against the recorded picture and the simulated mesh; ``drift_ssim`` and ``drift_rmse``
    against the cycle before, the first one against what was recorded.
    """
    values = {name: np.full((len(numbers), count), np.nan) for name in ("ssim", "rmse", "drift_ssim", "drift_rmse")}
    for sensor in sorted(set(frames.sensors[numbers])):
        rows = np.flatnonzero(frames.sensors[numbers] == sensor)
        true = Cycle(frames.displacements(numbers[rows]), frames.pictures(numbers[rows]))
        before = true
        walk = cycles(forth, back, true.pictures, frames.background(sensor), count)
        for number, found in enumerate(walk):
            values["ssim"][rows, number] = ssim(found.pictures, true.pictures)
            values["rmse"][rows, number] = rmse(found.displacements, true.displacements)
            values["drift_ssim"][rows, number] = ssim(found.pictures, before.pictures)
            values["drift_rmse"][rows, number] = rmse(found.displacements, before.displacements)
            before = found
    return values


def prepare_cyclic(workshop: Workshop) -> dict[str, tuple[LatentMeshToImage, LatentImageToMesh]]:
    """Both ways of each variant, trained."""
    found = {}
    for name in workshop.recipe.rows["methods"] or list(VARIANTS):
        if name not in VARIANTS:
            raise UnknownName("variant of the cycle", name, VARIANTS)
        latents = VARIANTS[name]
        mesh, image = workshop.mesh_vae, workshop.image_vae
        forth = LatentMeshToImage(name, mesh, image, workshop.projection("mesh_to_image", True), True, latents)
        back = LatentImageToMesh(name, image, mesh, workshop.projection("image_to_mesh", True), True, latents)
        found[name] = (forth, back)
    return found


def cyclic_rows(workshop: Workshop) -> list[dict[str, Any]]:
    """A row for each part, variant and cycle; means over evenly spaced frames. The strip is written beside."""
    settings = workshop.recipe.rows
    rows = []
    for part in settings["parts"]:
        frames = workshop.frames(part)
        chosen = np.unique(np.linspace(0, len(frames) - 1, min(settings["frames"], len(frames))).astype(np.int64))
        for name, (forth, back) in prepare_cyclic(workshop).items():
            workshop.tell(0, 1, f"{part}: {name}")
            values = cycle_values(forth, back, frames, chosen, settings["cycles"])
            units = {"ssim": "", "rmse": "mm", "drift_ssim": "", "drift_rmse": "mm"}
            for cycle in range(settings["cycles"]):
                scores = {
                    score: {
                        "value": float(one[:, cycle].mean()),
                        "frames": len(chosen),
                        "unit": units[score],
                        "better": "higher" if score.endswith("ssim") else "lower",
                    }
                    for score, one in values.items()
                }
                rows.append({"part": part, "method": name, "cycle": cycle + 1, "scores": scores})
            write_strip(workshop.tables / f"strip-{part}-{name}.png", forth, back, frames, chosen[-2:])
    return rows


def write_strip(
    path: Path, forth: LatentMeshToImage, back: LatentImageToMesh, frames: TouchFrames, numbers: NDArray[np.int64]
) -> None:
    """A picture: for each frame a row with the recorded picture and those of the first cycles."""
    rows = []
    for number in numbers:
        shown = frames.pictures([int(number)])
        background = frames.background(frames.sensors[number])
        rows.append([shown[0], *(one.pictures[0] for one in cycles(forth, back, shown, background, STRIP))])
    write_grid(path, rows)
