"""Pictures of a named effect: gains of candidates, changes of the gel's parameters, errors, events, maps, forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.arrays import Array
from tactiledata.report.diagnosis_plots import AFTER, BEFORE, EventPicture, MapPicture, event_panel, map_panel
from tactiledata.report.marks import AXIS_COLOURS, MEASURED, SIMULATED
from tactiledata.report.plots import WIDTH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


GREY = "#8a929a"
FAR = 10.0
"""Largest gain, in units of what a claim needs, that is drawn on a linear axis."""
Interval = tuple[float, float, float]
"""Low end, value and high end of an interval."""


@dataclass(frozen=True)
class Moved:
    """A parameter of the gel without and with the named effects.

    Parameters
    ----------
    title : str
        Name of the parameter with its unit.
    before : Interval
        Interval without the effects.
    after : Interval, optional
        Interval with them.
    """

    title: str
    before: Interval
    after: Interval | None


@dataclass(frozen=True)
class ErrorPanel:
    """Errors of one kind on s sets of touches that were held out.

    Parameters
    ----------
    title : str
        Kind of error with its unit.
    names : s names
        Names of the sets.
    bars : dict, name -> s values
        Errors of each simulation; NaN where a set has none.
    floor : s values
        Errors that noise alone gives.
    """

    title: str
    names: Sequence[str]
    bars: dict[str, Sequence[float]]
    floor: Sequence[float]


@dataclass(frozen=True)
class OverlayPicture:
    """The measured forces of one trajectory, and those of several simulations.

    Parameters
    ----------
    title : str
        Title of the row.
    seconds : (n,)
        Times of the frames.
    measured : (n, 3) N
        Measured contact force, gel frame.
    simulated : dict, name -> (n, 3) N
        Force of each simulation.
    """

    title: str
    seconds: Array
    measured: Array
    simulated: dict[str, Array]


def draw_ladder(names: Sequence[str], evidence: Sequence[float], needed: Sequence[float]) -> Figure:
    """Draw the evidence of candidates, and how much evidence each of them needs for a claim.

    Parameters
    ----------
    names : sequence of str
        Labels of the candidates.
    evidence : sequence of float
        Logarithm of each candidate's Bayes factor against the plain simulation.
    needed : sequence of float
        Evidence that a claim of each candidate needs.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, 0.32 * len(names) + 0.8), layout="constrained")
    axis = figure.subplots()
    places = np.arange(len(names))
    axis.barh(places, evidence, color=AFTER, height=0.5, label="evidence")
    axis.plot(needed, places, "|", color=BEFORE, markersize=12, label="needed for a claim")
    axis.axvline(0.0, color="black", linewidth=0.6)
    axis.set_yticks(places, names, fontsize=8)
    axis.set_ylim(len(names) - 0.5, -0.5)
    usual = max(needed, default=1.0)
    if max(evidence, default=0.0) > FAR * usual:
        axis.set_xscale("symlog", linthresh=usual)
        axis.xaxis.set_major_formatter("{x:g}")
    axis.set_xlabel("evidence, logarithm of the Bayes factor", fontsize=8)
    axis.tick_params(axis="x", labelsize=7)
    return figure


def draw_movement(numbers: Sequence[Moved]) -> Figure:
    """Draw one panel for each parameter: its intervals before and after, and an arrow between them."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH / 3 * len(numbers), 1.5), layout="constrained")
    axes = figure.subplots(1, len(numbers), squeeze=False)[0]
    for axis, number in zip(axes, numbers, strict=True):
        rows = [("plain", number.before, BEFORE)]
        if number.after is not None:
            rows.append(("with effect", number.after, AFTER))
        for place, (_, (low, value, high), colour) in enumerate(rows):
            axis.plot([low, high], [place, place], color=colour, linewidth=2)
            axis.plot(value, place, "s", color=colour, markersize=5)
        if number.after is not None:
            ends = {"xy": (number.after[1], 0.9), "xytext": (number.before[1], 0.1)}
            axis.annotate("", **ends, arrowprops={"arrowstyle": "->", "color": "black", "linewidth": 1})
        axis.set_yticks(range(len(rows)), [name for name, _, _ in rows], fontsize=8)
        axis.set_ylim(len(rows) - 0.5, -0.5)
        axis.margins(x=0.15)
        axis.set_title(number.title, fontsize=9)
        axis.tick_params(axis="x", labelsize=7)
        axis.locator_params(axis="x", nbins=4)
    return figure


def draw_held_out(panels: Sequence[ErrorPanel]) -> Figure:
    """Draw bars of errors for each set that was held out; ticks show the errors that noise alone gives."""
    from matplotlib.figure import Figure

    sets, kinds = len(panels[0].names), len(panels[0].bars)
    figure = Figure(figsize=(WIDTH, 0.26 * sets * (kinds + 1) + 0.8), layout="constrained")
    axes = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
    colours = dict(zip(panels[0].bars, (BEFORE, AFTER, GREY), strict=False))
    for axis, panel in zip(axes, panels, strict=True):
        for row, (what, values) in enumerate(panel.bars.items()):
            places = np.arange(sets) * (kinds + 1.0) + row
            axis.barh(places, np.nan_to_num(values), color=colours[what], height=0.85, label=what)
        for number, floor in enumerate(panel.floor):
            ends = np.array([-0.5, kinds - 0.5]) + number * (kinds + 1.0)
            axis.plot([floor, floor], ends, color="black", linewidth=1.2, label="noise alone" if number == 0 else None)
        axis.set_title(panel.title, fontsize=9)
        axis.tick_params(labelsize=7, labelleft=True)
    # labels of the sets
    middle = np.arange(sets) * (kinds + 1.0) + (kinds - 1) / 2
    axes[0].set_yticks(middle, panels[0].names, fontsize=8)
    axes[0].invert_yaxis()
    return figure


def draw_event_pairs(pairs: Sequence[tuple[EventPicture, EventPicture | None]]) -> Figure:
    """Draw the means about each event, without the effects on the left and with them on the right."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, 2.5 * len(pairs)), layout="constrained")
    axes = figure.subplots(len(pairs), 2, squeeze=False, sharey="row")
    for row, pair in enumerate(pairs):
        for axis, picture in zip(axes[row], pair, strict=True):
            if picture is None:
                axis.set_axis_off()
            else:
                event_panel(axis, picture)
                axis.tick_params(labelleft=True)
    return figure


def draw_map_pair(pictures: Sequence[MapPicture]) -> Figure:
    """Draw maps side by side with one scale of colours."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH / 2 * len(pictures), 3.8), layout="constrained")
    limit = max(float(np.nanmax(np.abs(picture.values), initial=1e-300)) for picture in pictures)
    for axis, picture in zip(figure.subplots(1, len(pictures), squeeze=False)[0], pictures, strict=True):
        map_panel(figure, axis, picture, limit)
    return figure


def draw_overlays(pictures: Sequence[OverlayPicture]) -> Figure:
    """Draw forces, a row per trajectory and a column per component: measured points, simulated lines."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, 2.1 * len(pictures) + 0.2), layout="constrained")
    axes = figure.subplots(len(pictures), 3, squeeze=False)
    for row, picture in enumerate(pictures):
        for column, name in enumerate(AXIS_COLOURS):
            _overlay(axes[row, column], picture, column)
            axes[row, column].set_ylabel(f"{name.capitalize()}, N", fontsize=8)
            axes[row, column].set_xlabel("time, s", fontsize=8)
        axes[row, 0].set_title(picture.title, fontsize=9, loc="left")
    return figure


def _overlay(axis: Axes, picture: OverlayPicture, column: int) -> None:
    """Draw one component of the forces of a trajectory into a panel."""
    axis.plot(picture.seconds, picture.measured[:, column], **MEASURED, color="black", markersize=3, label="measured")
    for (what, force), colour, dashes in zip(picture.simulated.items(), (BEFORE, AFTER), ("--", "-"), strict=False):
        style = {**SIMULATED, "linestyle": dashes, "linewidth": 1.2}
        axis.plot(picture.seconds, force[:, column], **style, color=colour, label=f"simulated, {what}")
    axis.tick_params(labelsize=7)
