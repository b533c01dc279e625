"""The table of how long a frame takes from touch to picture: each step, its memory, and how like the picture is."""

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
from split_models.tables.step_race import Contender, Simulated, contenders, race, weigh
from tactiledata.arrays import PictureArray
from tactiledata.errors import UsageError
from tactiledata.metrics.image_similarity import IMAGE_SIMILARITY

SHOWN = 5
"""Frames of the picture of both resolutions."""


def prepare_time(recipe_run: RecipeRun) -> dict[str, Any]:
    """The methods, trained."""
    return {name: mesh_to_image(recipe_run, name) for name in recipe_run.recipe.rows["methods"] or ["split"]}


def time_rows(recipe_run: RecipeRun) -> list[dict[str, Any]]:
    """A row for each method and resolution; the picture of both resolutions is written beside.

    Raises
    ------
    UsageError
        No frame of the part could be simulated.
    """
    part = recipe_run.recipe.rows["parts"][0]
    runners = contenders(prepare_time(recipe_run))
    recorded = recorded_touches(recipe_run, part, recipe_run.recipe.rows["frames"])
    simulated = simulate(recorded.pad, recorded.touches, recipe_run.tell)
    known = [(place, frame) for place, frame in enumerate(simulated["low"].frames) if frame in recorded.numbers]
    if not known:
        raise UsageError(f"no frame of {part} that could be simulated", "touches of the store's own gel", "")
    drawn = [(place, recorded.sensors[touch]) for place, (touch, _) in known]
    backgrounds = {sensor: recorded.frames.background(sensor) for sensor in set(recorded.sensors)}
    race(runners, simulated, drawn, backgrounds, recipe_run.tell)
    weigh(runners, simulated, drawn[0], backgrounds)
    numbers = np.array([recorded.numbers[frame] for _, frame in known])
    figure, titles = resolution_figure(runners, recorded.frames.pictures(numbers), recorded_title(recipe_run.store))
    write_grid(recipe_run.tables / f"resolutions-{part}.png", figure, titles)
    rows = cost_rows(runners, simulated)
    for one, row in zip(runners, rows, strict=True):
        row["l1_contact"] = _likeness(one, recorded.frames, numbers)
    return [{"part": part, "method": one.title, "scores": row} for one, row in zip(runners, rows, strict=True)]


def cost_rows(runners: Sequence[Contender], simulated: Simulated) -> list[dict[str, Any]]:
    """Of each contender the median seconds a frame of every step, with the simulation at its resolution; memory.

    Networks also have how many times faster they are than the fastest method that draws height maps, at either
    resolution.
    """
    frames = len(runners[0].pictures)
    overall = [np.median(simulated[one.resolution].seconds) + one.drawing_seconds() for one in runners]
    fastest = {
        resolution: min(
            (time for one, time in zip(runners, overall, strict=True) if _is_optical_at(one, resolution)), default=None
        )
        for resolution in simulated
    }
    rows = []
    for one, total in zip(runners, overall, strict=True):
        simulation = simulated[one.resolution]
        steps = {"simulation": simulation.seconds, **one.seconds}
        row = {name: _scored(float(np.median(values)), frames, "s") for name, values in steps.items()}
        row["overall"] = _scored(float(total), frames, "s")
        for resolution, time in fastest.items():
            if time is not None and not one.is_optical:
                name = f"times faster than the fastest baseline, {resolution} resolution"
                row[name] = _scored(float(time / total), frames, "", "higher")
        for name, memory in (("memory to simulate", simulation.memory), ("memory to draw", one.memory)):
            if np.isfinite(memory):
                row[name] = _scored(memory, frames, "MB")
        rows.append(row)
    return _in_one_order(rows)


def resolution_figure(
    runners: Sequence[Contender], recorded: PictureArray, title: str
) -> tuple[list[list[PictureArray]], list[str]]:
    """Return a row for each of some frames: the recorded picture, then each contender's; and the titles of the columns.

    Parameters
    ----------
    runners : sequence of Contender
    recorded : (n, H, W, 3) uint8
    title : str
        Over the recorded pictures.
    """
    places = np.unique(np.linspace(0, len(recorded) - 1, SHOWN).astype(np.int64))
    rows = [[recorded[place], *(one.pictures[place] for one in runners)] for place in places]
    return rows, [title, *(one.title for one in runners)]


def _is_optical_at(one: Contender, resolution: str) -> bool:
    return one.is_optical and one.resolution == resolution


def _in_one_order(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """All columns in every row, steps before totals; without a value where a method has no such step."""
    columns = {name: score for row in rows for name, score in row.items()}
    order = sorted(columns, key=lambda name: name == "overall" or name.startswith(("times", "memory")))
    return [{name: row.get(name, {**columns[name], "value": None}) for name in order} for row in rows]


def _likeness(one: Contender, frames: TouchFrames, numbers: NDArray[np.int64]) -> dict[str, Any]:
    """Mean absolute difference to the recorded pictures, inside the contact."""
    score, true = IMAGE_SIMILARITY.scores["l1"], frames.pictures(numbers)
    values = np.full(len(numbers), np.nan)
    for sensor in set(frames.sensors[numbers]):
        mine = np.flatnonzero(frames.sensors[numbers] == sensor)
        region = contact_region(true[mine], frames.background(sensor))
        values[mine] = score(np.stack([one.pictures[place] for place in mine]), true[mine], region)
    return _scored(float(np.nanmean(values)), len(numbers), score.unit, score.better)


def _scored(value: float, frames: int, unit: str, better: str = "lower") -> dict[str, Any]:
    return {"value": value, "unit": unit, "better": better, "frames": frames}
