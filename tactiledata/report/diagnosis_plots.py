"""Pictures of a diagnosis: dependences on covariates, means about events, shares of the excess, maps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.report.marks import AXIS_COLOURS, JOINED_DIFFERENCE
from tactiledata.report.plots import WIDTH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


BEFORE, AFTER = "#c0392b", "#2c5aa0"
"""Colours of values without and with the explanation."""
ACROSS = 3
"""Number of pictures in a row."""
COLOURS = (*AXIS_COLOURS.values(), "#8e44ad", "#b8500a", "#0f766e")


@dataclass(frozen=True)
class Dependence:
    """Departures of a parameter from its mean, in bins of a covariate.

    Parameters
    ----------
    parameter, covariate : str
        Names of the axes with units.
    is_logarithmic : bool
        Whether the covariate's axis is logarithmic.
    places : (b,)
        Covariate of each bin.
    before, before_error : (b,)
        Departure and standard error without the explanation.
    after, after_error : (b,), optional
        The same with the explanation.
    """

    parameter: str
    covariate: str
    is_logarithmic: bool
    places: Array
    before: Array
    before_error: Array
    after: Array | None = None
    after_error: Array | None = None


@dataclass(frozen=True)
class EventPicture:
    """Means of residuals in the frames about an event.

    Parameters
    ----------
    title : str
        Title of the picture.
    frames : (w,)
        Number of each frame after the event.
    mean, error : (w, k)
        Means over trajectories and their standard errors.
    names : k components
        Names of the components.
    unit : str
        Unit of means and errors.
    """

    title: str
    frames: NDArray[np.int64]
    mean: Array
    error: Array
    names: tuple[str, ...]
    unit: str


@dataclass(frozen=True)
class MapPicture:
    """A map of departures over a plane.

    Parameters
    ----------
    title, across, up, unit : str
        Title, names of the axes, and unit of the values.
    x, y : (a,), (b,)
        Coordinates of the places.
    values : (b, a)
        Departures; NaN where they are unknown.
    stands_out : (b, a)
        Places outside the band of chance.
    """

    title: str
    across: str
    up: str
    unit: str
    x: Array
    y: Array
    values: Array
    stands_out: NDArray[np.bool_]


def literal(text: str) -> str:
    """Return a text in which matplotlib takes no dollar sign for mathematics."""
    return text.replace("$", r"\$")


def draw_dependences(
    panels: Sequence[Dependence], names: tuple[str, str] = ("scale and offset refitted", "with the formula")
) -> Figure:
    """Draw one panel for each pair of parameter and covariate; ``names`` are the labels of before and after."""
    from matplotlib.ticker import LogLocator, NullFormatter

    figure, axes = _grid(len(panels))
    for axis, panel in zip(axes, panels, strict=False):
        axis.errorbar(panel.places, panel.before, panel.before_error, **JOINED_DIFFERENCE, color=BEFORE, label=names[0])
        if panel.after is not None:
            axis.errorbar(
                panel.places, panel.after, panel.after_error, **JOINED_DIFFERENCE, color=AFTER, label=names[1]
            )
        axis.axhline(0.0, color="black", linewidth=0.6)
        if panel.is_logarithmic:
            axis.set_xscale("log")
            axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.xaxis.set_major_formatter("{x:g}")
            axis.xaxis.set_minor_formatter(NullFormatter())
        axis.set_xlabel(literal(panel.covariate), fontsize=8)
        axis.set_ylabel(literal(panel.parameter), fontsize=8)
        axis.tick_params(labelsize=7)
    return figure


def draw_events(pictures: Sequence[EventPicture]) -> Figure:
    """Draw means about events, over trajectories, with bands of two standard errors."""
    figure, axes = _grid(len(pictures))
    for axis, picture in zip(axes, pictures, strict=False):
        event_panel(axis, picture)
    return figure


def event_panel(axis: Axes, picture: EventPicture) -> None:
    """Draw the means of each component about one event into a panel."""
    for column, name in enumerate(picture.names):
        mean, error = picture.mean[:, column], 2 * picture.error[:, column]
        colour = COLOURS[column % len(COLOURS)]
        axis.fill_between(picture.frames, mean - error, mean + error, color=colour, alpha=0.15, linewidth=0)
        axis.plot(picture.frames, mean, **JOINED_DIFFERENCE, color=colour, label=literal(name))
    axis.axvline(-0.5, color="black", linewidth=0.6, linestyle=":")
    axis.axhline(0.0, color="black", linewidth=0.6)
    axis.set_title(literal(picture.title), fontsize=9)
    axis.set_xlabel("frames after the event", fontsize=8)
    axis.locator_params(axis="x", integer=True)
    axis.set_ylabel(picture.unit, fontsize=8)
    axis.tick_params(labelsize=7)


def draw_shares(names: Sequence[str], shares: Sequence[float], even: Sequence[float]) -> Figure:
    """Draw bars of shares, and ticks of the shares that an even spread would give.

    Parameters
    ----------
    names : sequence of str
        Labels of the bars.
    shares : sequence of float
        Share of the excess that each has.
    even : sequence of float
        Share of the values that each has.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, 0.28 * len(names) + 0.8), layout="constrained")
    axis = figure.subplots()
    places = np.arange(len(names))
    axis.barh(places, shares, color=AFTER, height=0.6, label="share of the excess")
    axis.plot(even, places, "|", color="black", markersize=9, label="share of all values")
    axis.set_yticks(places, [literal(name) for name in names], fontsize=8)
    axis.invert_yaxis()
    axis.set_xlabel("share", fontsize=8)
    axis.tick_params(axis="x", labelsize=7)
    return figure


def draw_errors(names: Sequence[str], errors: Sequence[float], unit: str) -> Figure:
    """Draw bars of root mean squares.

    Parameters
    ----------
    names : sequence of str
        Labels of the bars.
    errors : sequence of float
        Root mean squares.
    unit : str
        Their unit.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 0.35 * len(names) + 0.6), layout="constrained")
    axis = figure.subplots()
    places = np.arange(len(names))
    axis.barh(places, errors, color=[BEFORE, AFTER, *["#8a929a"] * len(names)][: len(names)], height=0.6)
    axis.set_yticks(places, [literal(name) for name in names], fontsize=8)
    axis.invert_yaxis()
    axis.set_xlabel(f"root mean square, {unit}", fontsize=8)
    axis.tick_params(axis="x", labelsize=7)
    return figure


def draw_map(picture: MapPicture) -> Figure:
    """Draw a map of departures over the plane; crosses mark places outside the band of chance."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5, 4), layout="constrained")
    map_panel(figure, figure.subplots(), picture, float(np.nanmax(np.abs(picture.values), initial=1e-300)))
    return figure


def map_panel(figure: Figure, axis: Axes, picture: MapPicture, limit: float) -> None:
    """Draw a map into a panel of a figure.

    Parameters
    ----------
    figure : Figure
        The figure, which gets a bar of colours.
    axis : Axes
        The panel.
    picture : MapPicture
        The map.
    limit : float
        Value up to which colours reach, in both directions.
    """
    drawn = axis.pcolormesh(
        picture.x, picture.y, picture.values, cmap="RdBu_r", vmin=-limit, vmax=limit, shading="nearest"
    )
    row, column = np.nonzero(picture.stands_out)
    axis.plot(picture.x[column], picture.y[row], "x", color="black", markersize=4, label="outside the band of chance")
    bar = figure.colorbar(drawn, ax=axis)
    bar.set_label(picture.unit, fontsize=8)
    axis.set_title(literal(picture.title), fontsize=9)
    axis.set_xlabel(literal(picture.across), fontsize=8)
    axis.set_ylabel(literal(picture.up), fontsize=8)
    axis.tick_params(labelsize=7)
    axis.set_aspect("equal")


def _grid(count: int) -> tuple[Figure, list[Axes]]:
    """Return a figure and its panels in rows, of which ``count`` are used and the others switched off."""
    from matplotlib.figure import Figure

    rows = max(1, -(-count // ACROSS))
    figure = Figure(figsize=(WIDTH, 2.5 * rows), layout="constrained")
    axes = list(figure.subplots(rows, ACROSS, squeeze=False).flat)
    for axis in axes[count:]:
        axis.set_axis_off()
    return figure, axes
