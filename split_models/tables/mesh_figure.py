"""Meshes of pictures side by side: the recorded picture, the simulated mesh, each method's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from split_models.learning.data import TouchFrames
from split_models.methods.methods import for_sensor, title_of
from split_models.tables.mesh_picture import MeshPictures
from tactiledata.arrays import PictureArray
from tactiledata.metrics.mesh_distance import rmse
from tactiledata.optics.surface import GelSurface


def mesh_figure(
    methods: Mapping[str, Any], frames: TouchFrames, surface: GelSurface, recorded: str = "recorded", count: int = 6
) -> tuple[list[list[PictureArray]], list[str], list[str]]:
    """For some frames, evenly spaced, a row of pictures; titles of columns and of rows.

    Colours of a row are as deep as its simulated mesh; titles of rows say how deep, and each method's RMSE.

    Parameters
    ----------
    methods : dict, name -> method, trained
    frames : TouchFrames
    surface : GelSurface
    recorded : str
        The title over the recorded pictures.
    count : int
        Rows at most.
    """
    assert frames.size is not None  # recipes state it
    shown, labels = [], []
    for number in np.unique(np.linspace(0, len(frames) - 1, count).astype(np.int64)):
        sensor, true = frames.sensors[number], frames.displacements([int(number)])
        picture, background = frames.pictures([int(number)]), frames.background(sensor)
        made = {name: for_sensor(one, sensor).predict(picture, background) for name, one in methods.items()}
        deepest = float(-true[0, :, 2].min())
        drawn = MeshPictures(surface, frames.size, deepest)
        shown.append([picture[0], drawn.draw(true[0]), *(drawn.draw(one[0]) for one in made.values())])
        errors = "".join(f"\n{title_of(name)}: {rmse(one, true)[0]:.3f} mm" for name, one in made.items())
        labels.append(f"{frames.indenters[number]} on {sensor}, {1e3 * deepest:.2f} mm deep{errors}")
    return shown, [recorded, "simulated mesh", *(title_of(name) for name in methods)], labels
