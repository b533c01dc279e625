"""Pictures of a calibration: measured and simulated forces, residuals, and the loss around its optimum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.arrays import Array
from tactiledata.report.marks import AXIS_COLOURS, DIFFERENCE, MEASURED, SIMULATED
from tactiledata.report.plots import WIDTH

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ACROSS = 4
"""Number of pictures in a row."""


@dataclass(frozen=True)
class Overlay:
    """The measured and simulated forces of one trajectory.

    Parameters
    ----------
    title : str
        Title of the picture.
    seconds : (n,) s
        Times of the frames.
    measured, simulated : (n, 3) N
        Contact forces, gel frame.
    """

    title: str
    seconds: Array
    measured: Array
    simulated: Array


@dataclass(frozen=True)
class LossSurface:
    """A loss over two parameters, with the third one fitted at each place or held.

    Parameters
    ----------
    title, across, up, unit : str
        Title, names of the axes with units, and name of the loss with its unit.
    x, y : (p,), (q,)
        Values of the parameters.
    loss : (q, p)
        The loss at each pair of values.
    best : (x, y)
        The optimum.
    contour : float
        Loss at the border of the 95 % region; NaN draws no border.
    """

    title: str
    across: str
    up: str
    unit: str
    x: Array
    y: Array
    loss: Array
    best: tuple[float, float]
    contour: float


def draw_overlays(overlays: Sequence[Overlay]) -> Figure:
    """Draw measured forces as dots and simulated forces as lines, four trajectories in a row."""
    from matplotlib.figure import Figure

    rows = max(1, -(-len(overlays) // ACROSS))
    figure = Figure(figsize=(WIDTH, 2.2 * rows), layout="constrained")
    axes = figure.subplots(rows, ACROSS, squeeze=False)
    for place, axis in enumerate(axes.flat):
        if place >= len(overlays):
            axis.set_axis_off()
            continue
        overlay = overlays[place]
        for what, forces, style in (
            ("measured", overlay.measured, {**MEASURED, "markersize": 3}),
            ("simulated", overlay.simulated, {**SIMULATED, "linewidth": 1}),
        ):
            for name, values in zip(AXIS_COLOURS, forces.T, strict=True):
                label = f"{name.capitalize()} {what}"
                axis.plot(overlay.seconds, values, **style, color=AXIS_COLOURS[name], label=label)
        axis.set_title(overlay.title, fontsize=8)
        axis.tick_params(labelsize=7)
        axis.set_ylabel("force, N", fontsize=8)
        axis.set_xlabel("time, s", fontsize=8)
    return figure


def draw_surfaces(surfaces: Sequence[LossSurface]) -> Figure:
    """Draw maps of the loss side by side, with the optimum marked."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH / 2 * len(surfaces), 3.4), layout="constrained")
    axes = figure.subplots(1, len(surfaces), squeeze=False)[0]
    for axis, surface in zip(axes, surfaces, strict=True):
        drawn = axis.contourf(surface.x, surface.y, surface.loss, levels=20, cmap="viridis_r")
        bar = figure.colorbar(drawn, ax=axis)
        bar.set_label(surface.unit, fontsize=8)
        bar.ax.tick_params(labelsize=7)
        if np.isfinite(surface.contour) and surface.loss.min() < surface.contour < surface.loss.max():
            axis.contour(surface.x, surface.y, surface.loss, levels=[surface.contour], colors="white")
        axis.plot(
            *surface.best, "x", color="red", markersize=8, markeredgewidth=2, clip_on=False, zorder=5, label="optimum"
        )
        axis.set_title(surface.title, fontsize=9)
        axis.set_xlabel(surface.across, fontsize=8)
        axis.set_ylabel(surface.up, fontsize=8)
        axis.tick_params(labelsize=7)
    return figure


def draw_residuals(measured: Array, residual: Array, names: Sequence[str]) -> Figure:
    """Draw residuals over the measured normal force, and their histogram.

    Parameters
    ----------
    measured : (n,) N
        Measured normal force.
    residual : (n, 3) N
        Measured less simulated force.
    names : sequence of str
        Names of the three components.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, 3.0), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=[2, 1])
    limit = float(np.percentile(np.abs(residual), 99.5)) * 1.3 or 1.0
    for column, (name, colour) in enumerate(zip(names, AXIS_COLOURS.values(), strict=True)):
        left.plot(measured, residual[:, column], **DIFFERENCE, color=colour, markersize=3.5, label=name)
        right.hist(residual[:, column], bins=np.linspace(-limit, limit, 31), histtype="step", color=colour)
    left.axhline(0.0, color="black", linewidth=0.6)
    left.set_xlabel("measured normal force, N", fontsize=8)
    left.set_ylabel("measured \N{MINUS SIGN} simulated, N", fontsize=8)
    right.set_xlabel("measured \N{MINUS SIGN} simulated, N", fontsize=8)
    right.set_ylabel("frames", fontsize=8)
    for axis in (left, right):
        axis.tick_params(labelsize=7)
    return figure
