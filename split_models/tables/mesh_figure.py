"""The figure of meshes side by side: the recorded picture, the simulated mesh, and each method's mesh."""

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
    methods: Mapping[str, Any],
    frames: TouchFrames,
    surface: GelSurface,
    recorded: str = "recorded",
    count: int = 6,
    titles: Mapping[str, str] | None = None,
) -> tuple[list[list[PictureArray]], list[str], list[str]]:
    """Pictures of meshes for some evenly spaced frames, one row each; then titles of the columns and of the rows.

    The colour scale of a row ends at the deepest point of its simulated mesh. Titles of rows state that depth, and the
    RMSE of each method.

    Parameters
    ----------
    methods : dict
        Trained image-to-mesh methods by name.
    frames : TouchFrames
        Frames of a part of the split.
    surface : GelSurface
        Surface of the mesh.
    recorded : str
        Title over the recorded pictures.
    count : int
        Largest number of rows.
    titles : dict, optional
        Titles of rows that a recipe gives.
    """
    assert frames.size is not None  # recipes state it
    shown, labels = [], []
    for number in np.unique(np.linspace(0, len(frames) - 1, count).astype(np.int64)):
        sensor, true = frames.sensors[number], frames.displacements([int(number)])
        picture, background = frames.pictures([int(number)]), frames.background(sensor)
        made = {name: for_sensor(method, sensor).predict(picture, background) for name, method in methods.items()}
        deepest = float(-true[0, :, 2].min())
        drawn = MeshPictures(surface, frames.size, deepest)
        shown.append([picture[0], drawn.draw(true[0]), *(drawn.draw(mesh[0]) for mesh in made.values())])
        errors = "".join(f"\n{title_of(name, titles)}: {rmse(mesh, true)[0]:.3f} mm" for name, mesh in made.items())
        labels.append(f"{frames.indenters[number]} on {sensor}, {1e3 * deepest:.2f} mm deep{errors}")
    return shown, [recorded, "simulated mesh", *(title_of(name, titles) for name in methods)], labels
