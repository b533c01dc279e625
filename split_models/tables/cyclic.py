"""Repeated cycles of picture to mesh to picture: how far each is from the recording and from the cycle before."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from split_models.learning.contact_region import contact_region
from split_models.learning.data import TouchFrames
from split_models.methods.cycle import cycle_pair
from split_models.methods.methods import title_of
from split_models.methods.optical_method import surface_of
from split_models.networks.latent import LatentImageToMesh, LatentMeshToImage, Latents
from split_models.recipe.recipe_run import RecipeRun
from split_models.tables.cyclic_plot import write_cycle_plot
from split_models.tables.evaluate import MASKED, summarised
from split_models.tables.mesh_picture import MeshPictures
from split_models.tables.picture_grid import write_grid
from tactiledata.contract.atomic import write_json_atomic
from tactiledata.errors import UnknownName
from tactiledata.metrics.image_similarity import IMAGE_SIMILARITY, ssim
from tactiledata.metrics.mesh_distance import MESH_DISTANCE, rmse
from tactiledata.report.plots import difference_picture

Values = dict[str, NDArray[np.float64]]
Ways = tuple[LatentMeshToImage, LatentImageToMesh]
VARIANTS = ("split", "split_sampled", "split_cycle_only", "split_cycle")
"""Rows: latent means, latent samples as in the paper, and two kinds of projections that were trained together."""
SHOWN = (1, 2, 5, 10, 20, 40)
"""Cycles that the table shows, beside the last one; ``cycles.json`` has all."""
STRIP = 5
"""Cycles in a strip of pictures."""
_SSIM, _RMSE = IMAGE_SIMILARITY.scores["ssim"], MESH_DISTANCE.scores["rmse"]
SCORES = {"ssim": _SSIM, "rmse": _RMSE, "drift_ssim": _SSIM, "drift_rmse": _RMSE}
"""Scores by their column, for units and directions."""


@dataclass(frozen=True)
class Cycle:
    """The result of one cycle: meshes of the pictures before it, and pictures of these meshes.

    Parameters
    ----------
    displacements : (n, v, 3) m
    pictures : (n, h, w, 3) uint8
    """

    displacements: NDArray[np.float32]
    pictures: NDArray[np.uint8]


def cycles(
    forth: LatentMeshToImage,
    back: LatentImageToMesh,
    pictures: NDArray[np.uint8],
    background: NDArray[np.uint8],
    count: int,
) -> Iterator[Cycle]:
    """Yield the results of ``count`` cycles that start from pictures of one sensor.

    Parameters
    ----------
    forth, back : LatentMeshToImage, LatentImageToMesh
        Methods from meshes to pictures, and from pictures to meshes.
    pictures : (n, h, w, 3) uint8
        Recorded pictures.
    background : (h, w, 3) uint8
        The sensor's picture without contact.
    count : int
        Number of cycles.
    """
    for _ in range(count):
        displacements = back.predict(pictures, background)
        pictures = forth.predict(displacements, background)
        yield Cycle(displacements, pictures)


def cycle_values(
    forth: LatentMeshToImage, back: LatentImageToMesh, frames: TouchFrames, numbers: NDArray[np.int64], count: int
) -> Values:
    """Scores (frames, cycles) of repeated cycles.

    ``ssim``, of the full frame and inside the contact, and ``rmse`` (mm) compare with the recorded picture and the
    simulated mesh. ``drift_ssim`` and ``drift_rmse`` compare with the cycle before; the first cycle with the recording.

    Parameters
    ----------
    forth, back : LatentMeshToImage, LatentImageToMesh
        Methods from meshes to pictures, and from pictures to meshes.
    frames : TouchFrames
        Frames of a part of the split.
    numbers : (n,) int
        Numbers of the frames to start from.
    count : int
        Number of cycles.
    """
    names = ("ssim", f"ssim{MASKED}", "rmse", "drift_ssim", "drift_rmse")
    values = {name: np.full((len(numbers), count), np.nan) for name in names}
    for rows, true, background in _of_each_unit(frames, numbers):
        region, before = contact_region(true.pictures, background), true
        for number, cycle in enumerate(cycles(forth, back, true.pictures, background, count)):
            values["ssim"][rows, number] = ssim(cycle.pictures, true.pictures)
            values[f"ssim{MASKED}"][rows, number] = ssim(cycle.pictures, true.pictures, region)
            values["rmse"][rows, number] = rmse(cycle.displacements, true.displacements)
            values["drift_ssim"][rows, number] = ssim(cycle.pictures, before.pictures)
            values["drift_rmse"][rows, number] = rmse(cycle.displacements, before.displacements)
            before = cycle
    return values


def faded_values(frames: TouchFrames, numbers: NDArray[np.int64]) -> Values:
    """Scores (frames,) of the background as the picture, and of the undeformed mesh: the limit of fading."""
    values = {name: np.full(len(numbers), np.nan) for name in ("ssim", f"ssim{MASKED}", "rmse")}
    for rows, true, background in _of_each_unit(frames, numbers):
        plain = np.broadcast_to(background, true.pictures.shape)
        values["ssim"][rows] = ssim(plain, true.pictures)
        values[f"ssim{MASKED}"][rows] = ssim(plain, true.pictures, contact_region(true.pictures, background))
        values["rmse"][rows] = rmse(np.zeros_like(true.displacements), true.displacements)
    return values


def prepare_cyclic(recipe_run: RecipeRun) -> dict[str, Ways]:
    """Both trained methods, mesh to picture and picture to mesh, by variant.

    Raises
    ------
    UnknownName
        The recipe names a variant that does not exist.
    """
    ways = {}
    for name in recipe_run.recipe.rows["methods"] or list(VARIANTS):
        if name not in VARIANTS:
            raise UnknownName("variant of the cycle", name, VARIANTS)
        mesh, image = recipe_run.mesh_vae, recipe_run.image_vae
        if name.startswith("split_cycle"):
            pair = cycle_pair(recipe_run, learns_own=name == "split_cycle")
            forth, back = pair.forth, pair.back
        else:
            forth, back = recipe_run.projection("mesh_to_image", True), recipe_run.projection("image_to_mesh", True)
        latents: Latents = "sample" if name == "split_sampled" else "mean"
        ways[name] = (
            LatentMeshToImage(name, mesh, image, forth, True, latents),
            LatentImageToMesh(name, image, mesh, back, True, latents),
        )
    return ways


def cyclic_rows(recipe_run: RecipeRun) -> list[dict[str, Any]]:
    """Rows for each part: the limit of fading, then some cycles of each variant, over evenly spaced frames.

    Strips of pictures, curves and the scores of all cycles (``cycles.json``) are written as well.
    """
    rows, curves = [], {}
    for part in recipe_run.recipe.rows["parts"]:
        frames, variants = recipe_run.frames(part), prepare_cyclic(recipe_run)
        count = min(recipe_run.recipe.rows["frames"], len(frames))
        chosen = np.unique(np.linspace(0, len(frames) - 1, count).astype(np.int64))
        values_of, drawn, shown = {}, surface_pictures(recipe_run, frames, chosen), shown_on_strip(frames, chosen)
        for done, (name, (forth, back)) in enumerate(variants.items()):
            recipe_run.tell(done, len(variants), f"{part}: {name}")
            values_of[name] = cycle_values(forth, back, frames, chosen, recipe_run.recipe.rows["cycles"])
            strip = recipe_run.tables / f"strip-{part}-{name}.png"
            write_strip(strip, variants[name], frames, shown, drawn)
        rows += _part_rows(part, values_of, faded_values(frames, chosen), frames.trajectories[chosen], recipe_run)
        curves[part] = {name: _means(values) for name, values in values_of.items()}
        write_cycle_plot(
            recipe_run.tables / f"cycles-{part}.png", {title_of(n): curve for n, curve in curves[part].items()}
        )
    write_json_atomic(recipe_run.tables / "cycles.json", curves)
    return rows


def _part_rows(
    part: str, values_of: Mapping[str, Values], faded: Values, trajectories: Any, recipe_run: RecipeRun
) -> list[dict[str, Any]]:
    """Rows of a part: the limit of fading, then the shown cycles of each variant."""
    rounds, count = recipe_run.recipe.rows["rounds"], recipe_run.recipe.rows["cycles"]
    rows: list[dict[str, Any]] = [
        {"part": part, "method": "faded", "scores": summarised(faded, trajectories, rounds, SCORES)}
    ]
    for name, values in values_of.items():
        for cycle in sorted({*(shown for shown in SHOWN if shown <= count), count}):
            now = {score: by_cycle[:, cycle - 1] for score, by_cycle in values.items()}
            scores = summarised(now, trajectories, rounds, SCORES)
            rows.append({"part": part, "method": name, "cycle": cycle, "scores": scores})
    return rows


def _means(values: Values) -> dict[str, list[float]]:
    """Means over frames of each score, cycle by cycle."""
    return {name: np.nanmean(score, axis=0).round(6).tolist() for name, score in values.items()}


def surface_pictures(recipe_run: RecipeRun, frames: TouchFrames, numbers: NDArray[np.int64]) -> MeshPictures:
    """The renderer of meshes, whose colour scale ends at the deepest indentation of some frames.

    Parameters
    ----------
    recipe_run : RecipeRun
        The run whose store has the mesh.
    frames : TouchFrames
        Frames of a part of the split.
    numbers : (n,) int
        Numbers of the frames that set the scale.
    """
    deepest = float(-frames.displacements(numbers)[..., 2].min())
    assert frames.size is not None  # recipes state it
    return MeshPictures(surface_of(recipe_run), frames.size, deepest)


def shown_on_strip(frames: TouchFrames, numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """Numbers of two frames for a strip: the frame with the deepest indentation in each half of ``numbers``."""
    depths = -frames.displacements(numbers)[..., 2].min(axis=1)
    halves = np.array_split(np.arange(len(numbers)), 2)
    return np.array([numbers[half[depths[half].argmax()]] for half in halves if len(half)])


def write_strip(path: Path, ways: Ways, frames: TouchFrames, numbers: NDArray[np.int64], drawn: MeshPictures) -> None:
    """Write a PNG with three rows for each frame: meshes, pictures, and where these differ from the given picture.

    The first column shows what was given, the others what is there after each cycle. Differences are doubled about
    grey, which is none.

    Parameters
    ----------
    path : Path
    ways : (LatentMeshToImage, LatentImageToMesh)
        Methods of a cycle.
    frames : TouchFrames
        Frames of a part of the split.
    numbers : (n,) int
        Numbers of the frames to show.
    drawn : MeshPictures
        Renderer of the meshes.
    """
    rows, labels = [], []
    for number in numbers:
        shown, moved = frames.pictures([int(number)]), frames.displacements([int(number)])
        steps = list(cycles(*ways, shown, frames.background(frames.sensors[number]), STRIP))
        rows.append([drawn.draw(mesh) for mesh in (moved[0], *(step.displacements[0] for step in steps))])
        pictures = [shown[0], *(step.pictures[0] for step in steps)]
        rows += [pictures, [difference_picture(picture, shown[0]) for picture in pictures]]
        touch = f"{frames.indenters[number]} on {frames.sensors[number]}"
        labels += [f"{touch}\nmesh", "picture", "less the given picture, x2"]
    write_grid(path, rows, ["given", *(f"cycle {number + 1}" for number in range(STRIP))], labels)


def _of_each_unit(
    frames: TouchFrames, numbers: NDArray[np.int64]
) -> Iterator[tuple[NDArray[np.int64], Cycle, NDArray[np.uint8]]]:
    """Yield for each unit the places of its frames in ``numbers``, their recorded values, and the unit's background."""
    for sensor in sorted(set(frames.sensors[numbers])):
        rows = np.flatnonzero(frames.sensors[numbers] == sensor)
        mine = numbers[rows]
        yield rows, Cycle(frames.displacements(mine), frames.pictures(mine)), frames.background(sensor)
