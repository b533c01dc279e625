"""A picture of all indenters: each as the gel sees it, and its footprint."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactiledata.indenters import INDENTERS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from tactiledata.indenters.base import Indenter

COLUMNS = 5
"""Solids in a row of the picture."""
VIEW = {"elev": -28.0, "azim": -62.0}
"""Direction of view, degrees: from below, where the gel is, on the side that touches."""
FOOTPRINT_HALF_WIDTH = 0.0062
"""Half the width, m, of the gel that a footprint shows."""
FOOTPRINT_DEPTH = 0.001
"""Depth, m, of the press whose footprint is shown."""


def draw_gallery(path: Path, solids: Mapping[str, Indenter] | None = None) -> None:
    """Write a PNG of solids: each as seen from the gel, and below it the footprint of a 1 mm press.

    It needs matplotlib (extra ``report``).

    Parameters
    ----------
    path : Path
        File to write.
    solids : dict, name -> Indenter, optional
        Solids to draw; all of the table with their default sizes unless stated.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    # a grid of caption, solid and footprint for each solid
    shown = {name: INDENTERS[name]() for name in INDENTERS} if solids is None else dict(solids)
    rows = -(-len(shown) // COLUMNS)
    height = 4.0 * rows + 0.5  # inches
    figure = Figure(figsize=(2.5 * COLUMNS, height), dpi=110, facecolor="white")
    FigureCanvasAgg(figure)
    parts = [0.55, 1.75, 1.1]  # heights of caption, solid and footprint
    grid = figure.add_gridspec(
        3 * rows,
        COLUMNS,
        height_ratios=parts * rows,
        left=0.01,
        right=0.99,
        top=0.995,
        bottom=0.45 / height,
        hspace=0.14,
    )
    for index, (name, solid) in enumerate(shown.items()):
        row, column = divmod(index, COLUMNS)
        _write_caption(figure.add_subplot(grid[3 * row, column]), name, solid)
        _draw_solid(figure.add_subplot(grid[3 * row + 1, column], projection="3d"), solid)
        image = _draw_footprint(figure.add_subplot(grid[3 * row + 2, column]), solid)
    # one scale of depths for all footprints
    scale = figure.colorbar(
        image, cax=figure.add_axes((0.68, 0.5 / height, 0.27, 0.11 / height)), orientation="horizontal"
    )
    scale.set_label("rigid footprint of a 1 mm press: depth [mm] over x, y [mm]", fontsize=8)
    scale.ax.tick_params(labelsize=7)
    figure.savefig(path, metadata={"Software": None})


def _write_caption(axes: Axes, name: str, solid: Indenter) -> None:
    """Write the name of a solid and its sizes."""
    from textwrap import fill

    sizes = ", ".join(_size(key, value) for key, value in solid.sizes.items())
    axes.set_axis_off()
    axes.text(0.5, 0.5, name, ha="center", va="bottom", fontsize=12, weight="bold")
    axes.text(0.5, 0.42, fill(sizes, 38), ha="center", va="top", fontsize=7, color="0.3")


def _draw_solid(axes: Any, solid: Indenter) -> None:
    """Draw the surface of a solid, shaded, as seen from the gel."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    surface = solid.mesh()
    # far sides are left out: the painter's order of matplotlib mixes them up with near ones
    elevation, azimuth = np.radians(VIEW["elev"]), np.radians(VIEW["azim"])
    across = np.cos(elevation)
    is_near = surface.face_normals @ [across * np.cos(azimuth), across * np.sin(azimuth), np.sin(elevation)] > 0
    triangles, normals = 1e3 * np.asarray(surface.triangles)[is_near], surface.face_normals[is_near]
    light = np.array([-0.55, -0.50, -0.67])
    shade = 0.38 + 0.62 * np.clip(normals @ light, 0.0, 1.0) ** 0.9
    colour = shade[:, None] * np.array([0.58, 0.76, 0.97])
    # without smoothed edges: between triangles they would show as lines
    axes.add_collection3d(Poly3DCollection(triangles, facecolors=colour, antialiased=False))
    centre = 1e3 * surface.bounds.mean(axis=0)
    half = 0.35e3 * float(np.linalg.norm(surface.extents))
    axes.set(xlim=centre[0] + [-half, half], ylim=centre[1] + [-half, half], zlim=centre[2] + [-half, half])
    axes.set_box_aspect((1, 1, 1), zoom=1.12)
    axes.set_proj_type("ortho")
    axes.view_init(**VIEW)
    axes.set_axis_off()


def _size(name: str, value: float) -> str:
    """Return a size in words: lengths in mm, angles in degrees."""
    label = name.replace("_", " ")
    return f"{label} {np.degrees(value):.0f}°" if name.endswith("angle") else f"{label} {1e3 * value:g} mm"


def _draw_footprint(axes: Axes, solid: Indenter) -> Any:
    """Draw the depth over x and y to which the solid reaches below the surface; return the image."""
    steps = np.linspace(-FOOTPRINT_HALF_WIDTH, FOOTPRINT_HALF_WIDTH, 301)
    x, y = np.meshgrid(steps, steps)
    depth = np.maximum(FOOTPRINT_DEPTH - solid.height(x, y), 0.0)
    reach = 1e3 * FOOTPRINT_HALF_WIDTH
    image = axes.imshow(
        1e3 * depth, origin="lower", extent=(-reach, reach, -reach, reach), cmap="magma", vmin=0, vmax=1, aspect="equal"
    )
    axes.set_xticks([-5, 0, 5])
    axes.set_yticks([-5, 0, 5])
    axes.tick_params(labelsize=6, length=2, pad=1.5)
    return image
