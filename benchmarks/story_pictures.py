"""The picture of a story: E, nu and mu against the truth, a touch that was held out, and errors on what is unseen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.unseen.compare import HeldOutComparison
from tactiledata.effects import EFFECTS
from tactiledata.report.diagnosis_plots import AFTER, BEFORE
from tactiledata.report.naming_plots import GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SCALES = (("E, kPa", 1e-3, 0), ("nu", 1.0, 3), ("mu", 1.0, 3))
"""Title, factor and decimals."""
AXES = ("Fx", "Fy", "Fz")


@dataclass(frozen=True)
class Numbers:
    """E (Pa), nu and mu as something found them, with 95 % intervals (low, high) where it tells them."""

    title: str
    parameters: tuple[float, ...]
    intervals: tuple[tuple[float, float], ...] = ()


def draw_story(
    numbers: Sequence[Numbers], truth: Sequence[float], naming: NamingResult, shown: HeldOutComparison
) -> Figure:
    """What calibrations said; the touch that changes most; errors on unseen trajectories and indenters."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 5.4), layout="constrained")
    rows = figure.add_gridspec(2, 6)
    for place in range(len(SCALES)):
        _numbers(figure.add_subplot(rows[0, 2 * place : 2 * place + 2]), numbers, truth, place)
    _touch(figure.add_subplot(rows[1, :4]), naming, shown)
    _errors(figure.add_subplot(rows[1, 4:]), shown)
    return figure


def _numbers(axes: Axes, numbers: Sequence[Numbers], truth: Sequence[float], place: int) -> None:
    title, scale, decimals = SCALES[place]
    heights = np.arange(len(numbers))[::-1]
    values = [scale * one.parameters[place] for one in numbers]
    colours = [AFTER if one.title.startswith("with") else BEFORE for one in numbers]
    axes.axvline(scale * truth[place], color=GREY, linewidth=1.0)
    apart = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
    middle = {"ha": "center", "fontsize": 7, "bbox": apart}
    axes.text(
        scale * truth[place], len(numbers) - 0.4, f"truth {scale * truth[place]:.{decimals}f}", color=GREY, **middle
    )
    for one, height, colour in zip(numbers, heights, colours, strict=True):
        if one.intervals:
            low, high = one.intervals[place]
            axes.hlines(height, scale * low, scale * high, color=colour, linewidth=1.5)
    axes.scatter(values, heights, c=colours, s=36, zorder=3)
    for value, height in zip(values, heights, strict=True):
        axes.annotate(f"{value:.{decimals}f}", (value, height), (0, 7), textcoords="offset points", **middle)
    axes.set_yticks(heights, [one.title for one in numbers] if place == 0 else [""] * len(numbers), fontsize=8)
    axes.set_ylim(-0.6, len(numbers))
    axes.margins(x=0.2)
    axes.locator_params(axis="x", nbins=5)
    axes.set_title(title, fontsize=9)
    axes.tick_params(axis="x", labelsize=7)


def _touch(axes: Axes, naming: NamingResult, shown: HeldOutComparison) -> None:
    """The component of a held-out trajectory whose error falls most; without an effect, the one that is worst."""
    cases, errors = naming.whitened, shown.of_trajectories
    before, after = (cases.measured[:, :3] - one[:, :3] for one in (errors.before, errors.after))
    fell = np.add.reduceat(np.nan_to_num(before**2 - after**2 if shown.names else before**2), cases.starts)
    number, axis = np.unravel_index(int(np.argmax(fell)), fell.shape)
    case = cases.touch_set.touches[number]
    rows = slice(cases.starts[number], cases.starts[number] + len(case.touch))
    seconds = case.touch.seconds - case.touch.seconds[0]
    axes.plot(seconds, case.measured[:, axis], "k.", markersize=5, label="measured")
    axes.plot(seconds, errors.before[rows, axis], color=BEFORE, linewidth=1.2, label="simulated, plain")
    if shown.names:
        titles = " and ".join(EFFECTS[name]().title for name in shown.names)
        axes.plot(seconds, errors.after[rows, axis], color=AFTER, linewidth=1.2, label=f"with {titles}")
    axes.set_title(f"{AXES[axis]} of a held-out trajectory ({case.touch.indenter_name})", fontsize=9)
    axes.set_xlabel("seconds", fontsize=8)
    axes.set_ylabel("N", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.legend(fontsize=7, frameon=False)


def _errors(axes: Axes, shown: HeldOutComparison) -> None:
    width, places = 0.26, np.arange(len(shown.errors))
    bars = [("plain", BEFORE, [one.force.before for one in shown.errors])]
    if shown.names:
        bars.append(("with the effect", AFTER, [one.force.after for one in shown.errors]))
    bars.append(("noise alone", GREY, [one.force.floor for one in shown.errors]))
    for number, (title, colour, values) in enumerate(bars):
        drawn = axes.bar(places + (number - 1) * width, values, width, color=colour, label=title)
        axes.bar_label(drawn, fmt="%.3f", fontsize=6)
    axes.set_xticks(places, [one.unseen for one in shown.errors], fontsize=7)
    axes.set_title("Force error on what is unseen, N rms", fontsize=9)
    axes.margins(y=0.35)
    axes.tick_params(axis="y", labelsize=7)
    axes.legend(fontsize=7, frameon=False, loc="upper right", ncols=len(bars))
