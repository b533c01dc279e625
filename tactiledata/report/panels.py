"""A drawn figure as panels with a legend, so that a page lays panels side by side, or below one another on a phone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.report.drawing import drawing
from tactiledata.report.marks import marks_by_label
from tactiledata.report.page import LegendEntry, Panel, Picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RESOLUTION = 150
"""Dots per inch of panels."""
MARGIN = 3
"""Pixels between a cut and what is drawn behind it."""
GREY = 121
"""Grey level of words beside photographs: they can be read on a light and on a dark page."""


def panels_of(figure: Figure, caption: str) -> Picture:
    """Return a figure as a picture for a page: rows of panels, and a legend of all labels that were drawn.

    Each subplot is a panel, with its bar of colours if it has one. Neighbouring subplots that show photographs stay
    together in one panel, their words in grey. No panel has a background.

    Parameters
    ----------
    figure : Figure
        Figure whose subplots lie in one grid. It is drawn without background, and not changed but in
        the fonts that its texts fall back to.
    caption : str
        Text below the picture.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure.set_dpi(RESOLUTION)
    backgrounds = [figure.patch, *(axis.patch for axis in figure.axes)]
    opacities = [background.get_alpha() for background in backgrounds]
    for background in backgrounds:
        background.set_alpha(0.0)
    canvas = FigureCanvasAgg(figure)
    with drawing(figure):
        canvas.draw()
    drawn = np.asarray(canvas.buffer_rgba())[..., [2, 1, 0, 3]]
    for background, opacity in zip(backgrounds, opacities, strict=True):
        background.set_alpha(opacity)
    renderer = canvas.get_renderer()
    height, width = drawn.shape[:2]
    rows = _rows_of_groups([axis for axis in figure.axes if axis.get_subplotspec() is not None and _is_drawn(axis)])
    # top edges (pixels from above) of all rows but the first, which begins at the top
    tops = [0, *(max(0, height - _end(row, renderer, "y1") - MARGIN) for row in rows[1:]), height]
    # left edges of the columns in which a group begins, the same for all rows
    beginning: dict[int, list[list[Axes]]] = {}
    for group in (group for row in rows for group in row):
        beginning.setdefault(_span(group[0]).start, []).append(group)
    lefts = {
        column: 0 if column == min(beginning) else max(0, _end(groups, renderer, "x0") - MARGIN)
        for column, groups in beginning.items()
    }
    cut = [
        tuple(
            _panel(drawn, group, (slice(top, bottom), slice(lefts[_span(group[0]).start], _right(group, lefts, width))))
            for group in row
        )
        for row, top, bottom in zip(rows, tops, tops[1:], strict=False)
    ]
    return Picture(tuple(cut), caption, legend_of(figure.axes))


def _span(axis: Axes) -> range:
    """Return the columns of the grid that a subplot covers."""
    return axis.get_subplotspec().colspan  # type: ignore[union-attr]


def _right(group: Sequence[Axes], lefts: Mapping[int, int], width: int) -> int:
    """Return where a group of subplots ends, in pixels: where the next column begins, or at the right edge."""
    return min((left for column, left in lefts.items() if column >= _span(group[-1]).stop), default=width)


def _is_drawn(axis: Axes) -> bool:
    """Return whether a subplot shows anything: those that are switched off and empty do not."""
    return bool(axis.axison or axis.has_data())


def _is_photograph(axis: Axes) -> bool:
    """Return whether a subplot stands for a photograph: it has no ticks, whether or not there is a picture."""
    return axis.name != "3d" and not len(axis.get_xticks()) and not len(axis.get_yticks())


def _rows_of_groups(axes: Iterable[Axes]) -> list[list[list[Axes]]]:
    """Return the subplots of each row of the grid, neighbouring photographs in one group."""
    by_row: dict[int, list[Axes]] = {}
    for axis in axes:
        by_row.setdefault(axis.get_subplotspec().rowspan.start, []).append(axis)  # type: ignore[union-attr]
    rows = []
    for _, row in sorted(by_row.items()):
        groups: list[list[Axes]] = []
        for axis in sorted(row, key=lambda axis: _span(axis).start):
            if groups and _is_photograph(axis) and _is_photograph(groups[-1][-1]):
                groups[-1].append(axis)
            else:
                groups.append([axis])
        rows.append(groups)
    return rows


def _end(groups: Sequence[Sequence[Axes]], renderer: Any, side: str) -> int:
    """Return how far subplots with their labels reach, in pixels: ``"x0"`` to the left, ``"y1"`` to the top."""
    ends = [getattr(axis.get_tightbbox(renderer), side) for group in groups for axis in group]
    return int(min(ends)) if side == "x0" else int(np.ceil(max(ends)))


def _panel(drawn: NDArray[np.uint8], group: Sequence[Axes], cut: tuple[slice, slice]) -> Panel:
    """Return the part of a drawn figure (H, W, BGRA) that shows some subplots; ``cut`` are its rows and columns."""
    is_photograph = all(_is_photograph(axis) for axis in group)
    shown = drawn[cut]
    if is_photograph:
        # words and frames in grey, photographs as they are
        rows, columns = cut
        greyed = np.full_like(shown, GREY)
        greyed[..., 3] = shown[..., 3]
        for axis in group:
            box, above, left = axis.get_window_extent(), len(drawn) - rows.start, columns.start
            inside = (
                slice(above - round(box.y1), above - round(box.y0)),
                slice(round(box.x0) - left, round(box.x1) - left),
            )
            greyed[inside] = shown[inside]
        shown = greyed
    encoded = cv2.imencode(".png", shown)[1].tobytes()
    return Panel(encoded, shown.shape[1], "; ".join(filter(None, map(_words, group))), is_photograph)


def _words(axis: Axes) -> str:
    """Return what a subplot shows, in words: its title, and the names of its axes."""
    title = " ".join(filter(None, [axis.get_title(), axis.get_title(loc="left")]))
    up, across = axis.get_ylabel(), axis.get_xlabel()
    named = f"{up} over {across}" if up and across else up or across
    return ": ".join(" ".join(part.split()) for part in (title, named) if part).replace(r"\$", "$")


def legend_of(axes: Iterable[Axes]) -> tuple[LegendEntry, ...]:
    """Return an entry for each label that was drawn in any of some subplots, in order."""
    return tuple(_entry(mark, label) for label, mark in marks_by_label(axes).items())


def _entry(handle: Any, label: str) -> LegendEntry:
    """Return the entry of what was drawn under a label: marks and line of a curve, else a box."""
    from matplotlib.colors import to_hex
    from matplotlib.container import BarContainer, ErrorbarContainer

    words = label.replace(r"\$", "$")
    curve = handle[0] if isinstance(handle, ErrorbarContainer) else handle
    if isinstance(handle, BarContainer) or not hasattr(curve, "get_linestyle"):
        patch = handle[0] if isinstance(handle, BarContainer) else handle
        return LegendEntry(words, to_hex(patch.get_facecolor()), "box")
    colour = to_hex(curve.get_color())
    marker, line = curve.get_marker(), curve.get_linestyle()
    has_line = line not in ("None", "none", " ", "")
    if marker == "|":
        return LegendEntry(words, colour, "tick")
    if marker == "x":
        return LegendEntry(words, colour, "cross")
    if marker == "s":
        return LegendEntry(words, colour, "joined squares" if has_line else "square")
    if not has_line:
        return LegendEntry(words, colour, "dot")
    return LegendEntry(words, colour, "dashes" if line == "--" else "line")
