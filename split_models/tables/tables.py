"""The tables of the paper by name: what each one trains, and its rows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from split_models.learning.data import TouchFrames
from split_models.methods.methods import for_sensor, image_to_mesh, mesh_to_image, title_of
from split_models.methods.optical_method import surface_of
from split_models.networks.force_head import predicted_forces
from split_models.recipe.recipe_run import RecipeRun
from split_models.tables.cyclic import cyclic_rows, prepare_cyclic
from split_models.tables.domain_alignment import alignment_rows, prepare_alignment
from split_models.tables.evaluate import Values, image_values, mesh_values, summarised
from split_models.tables.inference_time import prepare_time, time_rows
from split_models.tables.interval_rows import interval_rows
from split_models.tables.mesh_figure import mesh_figure
from split_models.tables.paired_differences import difference_rows
from split_models.tables.picture_grid import write_grid
from split_models.tables.recorded_title import recorded_title
from tactiledata.errors import UnknownName, UsageError
from tactiledata.metrics.base import Metric
from tactiledata.metrics.force_error import FORCE_ERROR
from tactiledata.metrics.image_similarity import IMAGE_SIMILARITY
from tactiledata.metrics.mesh_distance import MESH_DISTANCE

Rows = list[dict[str, Any]]

# rows of each table unless the recipe names others
IMAGE_METHODS = ("no_contact", "end_to_end", "nosplit", "split")
MESH_METHODS = ("at_rest", "nosplit", "split")
FORCE_INPUTS = ("raw_mesh", "raw_image", "mesh", "image", "deformation", "projected_nosplit", "projected_split")


def chosen_rows(recipe_run: RecipeRun, default: Sequence[str]) -> list[str]:
    """Rows that a recipe names, or the paper's where it names none."""
    return list(recipe_run.recipe.rows["methods"] or default)


def scores_of(recipe_run: RecipeRun, default: Sequence[str]) -> list[str]:
    """Scores that a recipe names, or all where it names none."""
    return list(recipe_run.recipe.rows["scores"] or default)


def _scored(
    recipe_run: RecipeRun,
    part: str,
    frames: TouchFrames,
    methods: dict[str, Any],
    values_of: Callable[..., Any],
    metric: Metric,
) -> Rows:
    """A row for each method: the recipe's scores of a metric on a part, with intervals over trajectories."""
    names = scores_of(recipe_run, list(metric.scores))
    rounds, touches = recipe_run.recipe.rows["rounds"], frames.trajectories
    values: dict[str, Values] = {}
    rows: Rows = []
    for done, (name, method) in enumerate(methods.items()):
        recipe_run.tell(done, len(methods), f"{part}: {name}")
        values[name] = values_of(method, frames, names)
        rows.append({"part": part, "method": name, "scores": summarised(values[name], touches, rounds, metric.scores)})
    reference = reference_of(recipe_run, list(methods))
    title = title_of(reference, recipe_run.recipe.rows["titles"])
    return rows + difference_rows(part, values, reference, title, touches, rounds, metric.scores)


def reference_of(recipe_run: RecipeRun, methods: Sequence[str]) -> str:
    """The row that the others are compared with, frame by frame: the one that a recipe names, else SPLIT."""
    named = recipe_run.recipe.rows["against"]
    if named is None:
        return "split"
    if named not in methods:
        raise UnknownName("row to compare with", named, list(methods))
    return str(named)


# -- pictures --------------------------------------------------------------------------------------------------------


def prepare_images(recipe_run: RecipeRun) -> dict[str, Any]:
    """Trained methods of the table of pictures, by name."""
    return {name: mesh_to_image(recipe_run, name) for name in chosen_rows(recipe_run, IMAGE_METHODS)}


def image_rows(recipe_run: RecipeRun) -> Rows:
    """A row for each part and method: l1, MSE, SSIM and PSNR, of the full frame and inside the contact region."""
    methods = prepare_images(recipe_run)
    rows: Rows = []
    for part, frames in parts(recipe_run):
        rows += _scored(recipe_run, part, frames, methods, image_values, IMAGE_SIMILARITY)
        titles = recipe_run.recipe.rows["titles"]
        figure = side_by_side(methods, frames, recorded_title(recipe_run.store), titles=titles)
        write_grid(recipe_run.tables / f"pictures-{part}.png", *figure)
    return rows


def side_by_side(
    methods: dict[str, Any],
    frames: TouchFrames,
    recorded: str = "recorded",
    count: int = 6,
    titles: Mapping[str, str] | None = None,
) -> tuple[list[list[np.ndarray]], list[str], list[str]]:
    """Rows of pictures of evenly spaced frames, recorded and of each method; then titles of columns and of rows.

    Parameters
    ----------
    methods : dict
        Trained mesh-to-image methods by name.
    frames : TouchFrames
        Frames of a part of the split.
    recorded : str
        Title over the recorded pictures.
    count : int
        Largest number of rows.
    titles : dict, optional
        Titles of rows that a recipe gives.
    """
    shown, labels = [], []
    for number in np.unique(np.linspace(0, len(frames) - 1, count).astype(np.int64)):
        sensor, moved = frames.sensors[number], frames.displacements([int(number)])
        made = [for_sensor(method, sensor).predict(moved, frames.background(sensor))[0] for method in methods.values()]
        shown.append([frames.pictures([int(number)])[0], *made])
        labels.append(f"{frames.indenters[number]} on {sensor}")
    return shown, [recorded, *(title_of(name, titles) for name in methods)], labels


# -- meshes ----------------------------------------------------------------------------------------------------------


def prepare_meshes(recipe_run: RecipeRun) -> dict[str, Any]:
    """Trained methods of the table of meshes, by name."""
    return {name: image_to_mesh(recipe_run, name) for name in chosen_rows(recipe_run, MESH_METHODS)}


def mesh_rows(recipe_run: RecipeRun) -> Rows:
    """A row for each part and method: RMSE, l1 and Euclidean distance, mm."""
    methods = prepare_meshes(recipe_run)
    rows: Rows = []
    for part, frames in parts(recipe_run):
        rows += _scored(recipe_run, part, frames, methods, mesh_values, MESH_DISTANCE)
        titles = recipe_run.recipe.rows["titles"]
        figure = mesh_figure(methods, frames, surface_of(recipe_run), recorded_title(recipe_run.store), titles=titles)
        write_grid(recipe_run.tables / f"meshes-{part}.png", *figure)
    return rows


# -- forces ----------------------------------------------------------------------------------------------------------


def prepare_forces(recipe_run: RecipeRun) -> dict[str, list[Any]]:
    """Trained networks of each input, one for each seed.

    Raises
    ------
    UsageError
        The recipe has no wrench, or names an unknown input.
    """
    if not recipe_run.recipe.data["wrench"]:
        raise UsageError(
            "a table of forces of data without a wrench", "`wrench: contact_wrench`", "Correct the recipe."
        )
    networks: dict[str, list[Any]] = {}
    for name in chosen_rows(recipe_run, FORCE_INPUTS):
        if name not in FORCE_INPUTS:
            raise UsageError(f"the force table has no row {name!r}", f"of {', '.join(FORCE_INPUTS)}", "")
        if name == "raw_mesh":
            networks[name] = [recipe_run.raw_forces("mesh", seed) for seed in _seeds(recipe_run, "raw_seeds")]
        elif name == "raw_image":
            networks[name] = [recipe_run.raw_forces("image", seed) for seed in _seeds(recipe_run, "raw_seeds")]
        else:
            networks[name] = [recipe_run.force_head(name, seed) for seed in _seeds(recipe_run, "head_seeds")]
    return networks


def force_rows(recipe_run: RecipeRun) -> Rows:
    """A row for each part and input: MAE of fx, fy, fz and of the norm, N, as mean and standard deviation over seeds.

    Further rows say how often intervals hold the truth; they use all heads of an input and are calibrated on the
    validation part.
    """
    heads = prepare_forces(recipe_run)
    known, rows = recipe_run.frames("val"), []
    calibration = (_forces_of_all(recipe_run, "val", heads), known.forces(), known.trajectories)
    held: Rows = []
    for part, frames in parts(recipe_run):
        true, predicted = frames.forces(), _forces_of_all(recipe_run, part, heads)
        held += interval_rows(part, heads, predicted, true, frames.trajectories, calibration)
        for name, forces in predicted.items():
            means: dict[str, list[float]] = {score: [] for score in FORCE_ERROR.scores}
            for of_seed in forces:
                for score in means:
                    means[score].append(float(FORCE_ERROR.scores[score](of_seed, true).mean()))
            summary = {
                score: {
                    "value": float(np.mean(values)),
                    "deviation": float(np.std(values, ddof=1)) if values[1:] else None,
                    "seeds": len(values),
                    "unit": "N",
                    "better": "lower",
                }
                for score, values in means.items()
            }
            rows.append({"part": part, "method": name, "scores": summary})
    return rows + held


def _forces_of_all(recipe_run: RecipeRun, part: str, heads: dict[str, list[Any]]) -> dict[str, np.ndarray]:
    """Forces (h, n, 3), N, of a part's frames from each network, by input."""
    return {
        name: np.stack([_forces_of(recipe_run, part, name, network) for network in networks])
        for name, networks in heads.items()
    }


def _seeds(recipe_run: RecipeRun, which: str) -> range:
    """Seeds of an input's networks, from the recipe's own seed upwards."""
    first = recipe_run.recipe.seed
    return range(first, first + recipe_run.recipe.rows[which])


def _forces_of(recipe_run: RecipeRun, part: str, name: str, network: Any) -> np.ndarray:
    """Forces (n, 3), N, of a part's frames from one network."""
    frames = recipe_run.frames(part)
    if not name.startswith("raw_"):
        return predicted_forces(network, recipe_run.latents(part, name))
    import torch

    from split_models.networks.image_vae import as_input

    pieces = []
    for start in range(0, len(frames), 64):
        numbers = range(start, min(start + 64, len(frames)))
        given = (
            torch.from_numpy(frames.displacements(numbers))
            if name == "raw_mesh"
            else as_input(torch.from_numpy(frames.pictures(numbers)))
        )
        pieces.append(predicted_forces(network, given))
    return np.concatenate(pieces)


def parts(recipe_run: RecipeRun) -> list[tuple[str, Any]]:
    """The parts of the split that a recipe names, with their frames; a part without frames is refused."""
    return [(part, recipe_run.frames(part)) for part in recipe_run.recipe.rows["parts"]]


PREPARE: dict[str, Callable[[RecipeRun], Any]] = {
    "digit_images": prepare_images,
    "mesh": prepare_meshes,
    "force": prepare_forces,
    "inference_time": prepare_time,
    "cyclic": prepare_cyclic,
    "domain_alignment": prepare_alignment,
}
"""Functions that train all networks of a table."""

ROWS: dict[str, Callable[[RecipeRun], Rows]] = {
    "digit_images": image_rows,
    "mesh": mesh_rows,
    "force": force_rows,
    "inference_time": time_rows,
    "cyclic": cyclic_rows,
    "domain_alignment": alignment_rows,
}
"""Functions that give the rows of a table."""
