"""Touches of a store as the gel simulation plays them, with the pictures that were recorded of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from split_models.learning.data import TouchFrames
from split_models.recipe.recipe_run import RecipeRun
from split_models.tables.simulated_frames import Pad, surface_of_pad
from tactiledata.errors import UsageError
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.replay.options import ReplayOptions
from tactiledata.replay.plan import PlannedTouch, plan_replay
from tactiledata.store.read.reader import Store


@dataclass(frozen=True)
class RecordedTouches:
    """Touches of one part of a split, ready for the gel simulation.

    Parameters
    ----------
    pad : Pad
        The gel pad that they press.
    touches : list of GelTouch
    sensors : list of str
        Sensor of each touch.
    numbers : dict
        Number in ``frames`` of each (touch, frame), where the part has the frame.
    frames : TouchFrames
        Frames of the part.
    """

    pad: Pad
    touches: list[GelTouch]
    sensors: list[str]
    numbers: dict[tuple[int, int], int]
    frames: TouchFrames


def recorded_touches(recipe_run: RecipeRun, part: str, count: int) -> RecordedTouches:
    """Evenly spaced trajectories of a part that together have about ``count`` of its frames.

    Parameters
    ----------
    recipe_run : RecipeRun
        The run whose store is used.
    part : str
        Part of the recipe's split.
    count : int
        Number of frames after which no more trajectories are taken.

    Raises
    ------
    UsageError
        No trajectory can be replayed, or the store's mesh is not the low-resolution pad.
    """
    frames, store = recipe_run.frames(part), Store.open(recipe_run.store)
    options = _options(recipe_run)
    plan = plan_replay(store, options.pads, None)
    own = set(frames.trajectories)
    playable = [touch for touch in plan.touches if touch.obstacle is None and touch.uid in own]
    if not playable:
        raise UsageError(f"no trajectory of {part} can be replayed", "poses and described indenters", "")
    # about as many trajectories, evenly spaced, as hold the frames
    place_of = {int(row): number for number, row in enumerate(frames.rows)}
    step = max(1, len(playable) * count // max(len(frames), 1))
    chosen = playable[:: max(1, len(playable) // step)]
    touches: list[GelTouch] = []
    sensors: list[str] = []
    numbers: dict[tuple[int, int], int] = {}
    for touch in chosen:
        mine = {(len(touches), row - touch.frames[0]): place_of[row] for row in range(*touch.frames) if row in place_of}
        if len(numbers) < count and mine:
            touches.append(touch.gel_touch(store, 0.0))
            sensors.append(touch.sensor)
            numbers |= mine
    return RecordedTouches(_pad(recipe_run, plan.pads, playable[0], options), touches, sensors, numbers, frames)


def _pad(recipe_run: RecipeRun, pads: Any, touch: PlannedTouch, options: ReplayOptions) -> Pad:
    """The pad of a planned touch; a store whose mesh is not the low-resolution pad is refused."""
    planned = pads[touch.pad]
    surface, topology = surface_of_pad(planned.mesh, options.keep), recipe_run.topology
    if surface.places.shape != topology.places.shape or not np.allclose(surface.places, topology.places, atol=1e-7):
        raise UsageError(
            f"a mesh of {len(topology.places)} vertices in the store, which is not the low-resolution pad",
            f"the low-resolution pad of {len(surface.places)} vertices, to compare with the high-resolution pad",
            "Name a mesh of `tactiledata replay --resolution low` under `data.mesh`.",
        )
    return Pad(planned.sensor, planned.geometry, options.material, options.fidelity, options.keep)


def _options(recipe_run: RecipeRun) -> ReplayOptions:
    """Options with which the store was replayed, at low resolution."""
    frames = recipe_run.frames("train")
    known = frames.arrays.store.mesh(frames.mesh_name).settings
    material = GelMaterial(**known["material"])
    return ReplayOptions(material, resolution="low", fidelity=known["fidelity"], keep=known["keep"])
