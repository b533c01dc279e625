"""Pictures of replayed touches: measured and simulated force over time, and the deformed gel in colour."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.report.marks import AXIS_COLOURS, MEASURED, SIMULATED
from tactiledata.report.plots import WIDTH

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class ReplayedTouch:
    """The forces and the deformed gel of one replayed touch.

    Parameters
    ----------
    title : str
        Title of the picture.
    seconds : (n,) s from the trajectory's start
        Times of the measured forces.
    measured : (n, 3) N
        Contact force, gel frame, at its native rate; empty where none was measured.
    frame_seconds : (m,) s
        Times of the images.
    simulated : (m, 3) N
        Simulated force at those times; NaN where there is no mesh.
    shown_second : float
        Time of the mesh that is shown, s.
    vertices : (v, 3) m, gel frame
        Undeformed vertices.
    displacement : (v, 3) m
        Displacements of the vertices.
    triangles : (t, 3)
        Vertex numbers of the outer surface's triangles.
    """

    title: str
    seconds: NDArray[np.float64]
    measured: NDArray[np.float64]
    frame_seconds: NDArray[np.float64]
    simulated: NDArray[np.float64]
    shown_second: float
    vertices: NDArray[np.float64]
    displacement: NDArray[np.float64]
    triangles: NDArray[np.int64]


def draw_replayed(touches: Sequence[ReplayedTouch]) -> Figure:
    """Draw a row per touch: the deformed surface at the largest force, and the forces over time."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, 2.5 * len(touches) + 0.3), layout="constrained")
    grid = figure.add_gridspec(len(touches), 2, width_ratios=[1, 2])
    for row, touch in enumerate(touches):
        _surface(figure.add_subplot(grid[row, 0], projection="3d"), touch)
        _forces(figure.add_subplot(grid[row, 1]), touch, is_last=row == len(touches) - 1)
    return figure


def _surface(axes: Any, touch: ReplayedTouch) -> None:
    """Draw the deformed outer surface in colours of displacement, mm."""
    x, y, z = 1e3 * (touch.vertices + touch.displacement).T
    moved = 1e3 * np.linalg.norm(touch.displacement, axis=1)
    drawn = axes.plot_trisurf(x, y, z, triangles=touch.triangles, cmap="viridis", linewidth=0.1, edgecolor="#00000030")
    drawn.set_array(moved[touch.triangles].mean(axis=1))
    drawn.set_clim(0.0, max(float(moved.max()), 1e-6))
    axes.set_box_aspect((np.ptp(x), np.ptp(y), max(2.0 * np.ptp(z), 1.0)))
    axes.view_init(elev=48, azim=-60)
    axes.set_axis_off()
    axes.set_title(touch.title, fontsize=8)
    bar = axes.figure.colorbar(drawn, ax=axes, shrink=0.6, pad=0.0)
    bar.set_label("moved, mm", fontsize=7)
    bar.ax.tick_params(labelsize=7)


def _forces(axes: Axes, touch: ReplayedTouch, is_last: bool) -> None:
    """Draw measured forces as dots and simulated forces as lines, over time."""
    for what, seconds, forces, style in (
        ("measured", touch.seconds, touch.measured, {**MEASURED, "markersize": 1.8, "alpha": 0.6}),
        ("simulated", touch.frame_seconds, touch.simulated, {**SIMULATED, "linewidth": 1.3}),
    ):
        for name, values in zip(AXIS_COLOURS, forces.T, strict=True):
            axes.plot(seconds, values, **style, color=AXIS_COLOURS[name], label=f"{name.capitalize()} {what}")
    axes.axvline(touch.shown_second, color="black", linewidth=0.8, linestyle=":")
    axes.set_ylabel("force, N (gel frame)", fontsize=8)
    axes.tick_params(labelsize=8)
    if is_last:
        axes.set_xlabel("time from the start of the trajectory, s", fontsize=8)
