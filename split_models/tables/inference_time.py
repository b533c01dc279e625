"""The table of times from touch to picture: each step's time, its memory, and the picture's error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from split_models.learning.contact_region import contact_region
from split_models.learning.data import TouchFrames
from split_models.methods.methods import mesh_to_image
from split_models.recipe.recipe_run import RecipeRun
from split_models.tables.picture_grid import write_grid
from split_models.tables.recorded_title import recorded_title
from split_models.tables.recorded_touches import recorded_touches
from split_models.tables.simulated_frames import simulate
from split_models.tables.step_race import Simulated, TimedMethod, measure_memory, time_methods, timed_methods
from tactiledata.arrays import PictureArray
from tactiledata.errors import UsageError
from tactiledata.metrics.image_similarity import IMAGE_SIMILARITY

SHOWN = 5
"""Frames in the picture that compares both resolutions."""


def prepare_time(recipe_run: RecipeRun) -> dict[str, Any]:
    """The methods of the table, trained, by name."""
    return {name: mesh_to_image(recipe_run, name) for name in recipe_run.recipe.rows["methods"] or ["split"]}


def time_rows(recipe_run: RecipeRun) -> list[dict[str, Any]]:
    """Rows for each method and resolution; a picture that compares both resolutions is written as well.

    Raises
    ------
    UsageError
        No frame of the part could be simulated.
    """
    part = recipe_run.recipe.rows["parts"][0]
    timed = timed_methods(prepare_time(recipe_run))
    recorded = recorded_touches(recipe_run, part, recipe_run.recipe.rows["frames"])
    simulated = simulate(recorded.pad, recorded.touches, recipe_run.tell)
    # frames that both the simulation and the part of the split have
    known = [(place, frame) for place, frame in enumerate(simulated["low"].frames) if frame in recorded.numbers]
    if not known:
        raise UsageError(f"no frame of {part} that could be simulated", "touches of the store's own gel", "")
    drawn = [(place, recorded.sensors[touch]) for place, (touch, _) in known]
    backgrounds = {sensor: recorded.frames.background(sensor) for sensor in set(recorded.sensors)}
    # measure time, memory and error
    time_methods(timed, simulated, drawn, backgrounds, recipe_run.tell)
    measure_memory(timed, simulated, drawn[0], backgrounds)
    numbers = np.array([recorded.numbers[frame] for _, frame in known])
    figure, titles = resolution_figure(timed, recorded.frames.pictures(numbers), recorded_title(recipe_run.store))
    write_grid(recipe_run.tables / f"resolutions-{part}.png", figure, titles)
    rows = cost_rows(timed, simulated)
    for timed_method, row in zip(timed, rows, strict=True):
        row["l1_contact"] = _likeness(timed_method, recorded.frames, numbers)
    return [
        {"part": part, "method": timed_method.title, "scores": row}
        for timed_method, row in zip(timed, rows, strict=True)
    ]


def cost_rows(timed: Sequence[TimedMethod], simulated: Simulated) -> list[dict[str, Any]]:
    """Rows of costs: the median time of each step in seconds a frame, the simulation's included, and memory in MB.

    Rows of networks also say how many times faster they are than the fastest method that draws height maps, at either
    resolution.

    Parameters
    ----------
    timed : sequence of TimedMethod
        Methods with measured times and memory.
    simulated : dict
        Simulated frames by resolution.
    """
    frames = len(timed[0].pictures)
    overall = [
        np.median(simulated[timed_method.resolution].seconds) + timed_method.drawing_seconds() for timed_method in timed
    ]
    fastest = {
        resolution: min(
            (
                time
                for timed_method, time in zip(timed, overall, strict=True)
                if _is_optical_at(timed_method, resolution)
            ),
            default=None,
        )
        for resolution in simulated
    }
    rows = []
    for timed_method, total in zip(timed, overall, strict=True):
        simulation = simulated[timed_method.resolution]
        steps = {"simulation": simulation.seconds, **timed_method.seconds}
        row = {name: _scored(float(np.median(values)), frames, "s") for name, values in steps.items()}
        row["overall"] = _scored(float(total), frames, "s")
        for resolution, time in fastest.items():
            if time is not None and not timed_method.is_optical:
                name = f"times faster than the fastest baseline, {resolution} resolution"
                row[name] = _scored(float(time / total), frames, "", "higher")
        for name, memory in (("memory to simulate", simulation.memory), ("memory to draw", timed_method.memory)):
            if np.isfinite(memory):
                row[name] = _scored(memory, frames, "MB")
        rows.append(row)
    return _in_one_order(rows)


def resolution_figure(
    timed: Sequence[TimedMethod], recorded: PictureArray, title: str
) -> tuple[list[list[PictureArray]], list[str]]:
    """Rows of pictures, recorded and of each method, for some evenly spaced frames; and the titles of the columns.

    Parameters
    ----------
    timed : sequence of TimedMethod
        Methods with their pictures.
    recorded : (n, H, W, 3) uint8
        Recorded pictures.
    title : str
        Title over the recorded pictures.
    """
    places = np.unique(np.linspace(0, len(recorded) - 1, SHOWN).astype(np.int64))
    rows = [[recorded[place], *(timed_method.pictures[place] for timed_method in timed)] for place in places]
    return rows, [title, *(timed_method.title for timed_method in timed)]


def _is_optical_at(timed_method: TimedMethod, resolution: str) -> bool:
    """Whether a method draws height maps of meshes of a resolution."""
    return timed_method.is_optical and timed_method.resolution == resolution


def _in_one_order(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Rows with the same columns, steps before totals; the value is None where a method has no such step."""
    columns = {name: score for row in rows for name, score in row.items()}
    order = sorted(columns, key=lambda name: name == "overall" or name.startswith(("times", "memory")))
    return [{name: row.get(name, {**columns[name], "value": None}) for name in order} for row in rows]


def _likeness(timed_method: TimedMethod, frames: TouchFrames, numbers: NDArray[np.int64]) -> dict[str, Any]:
    """Mean absolute difference to the recorded pictures in grey levels, inside the contact."""
    score, true = IMAGE_SIMILARITY.scores["l1"], frames.pictures(numbers)
    values = np.full(len(numbers), np.nan)
    for sensor in set(frames.sensors[numbers]):
        mine = np.flatnonzero(frames.sensors[numbers] == sensor)
        region = contact_region(true[mine], frames.background(sensor))
        values[mine] = score(np.stack([timed_method.pictures[place] for place in mine]), true[mine], region)
    return _scored(float(np.nanmean(values)), len(numbers), score.unit, score.better)


def _scored(value: float, frames: int, unit: str, better: str = "lower") -> dict[str, Any]:
    """A cell of the table: value, unit, direction and number of frames."""
    return {"value": value, "unit": unit, "better": better, "frames": frames}
