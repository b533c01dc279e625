"""Pictures of recordings, drawn with matplotlib's object interface: no window, no global state."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tactiledata.report.drawing import drawing
from tactiledata.report.marks import AXIS_COLOURS, MEASURED, marks_by_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH = 9.6
"""Width of a wide figure, inches: as wide as a page, so that texts keep their size."""


DRAWN_FORCE = 1e300
"""Forces beyond it, N, are drawn at it: the span of an axis would be no number."""


@dataclass(frozen=True)
class TouchPicture:
    """The pictures and the force of one recorded touch.

    Parameters
    ----------
    title : str
        Title of the row.
    background, image : (H, W, 3) uint8 RGB
        Picture without contact (``None`` where it is unknown), and picture at the largest force.
    seconds : (n,) s from the trajectory's start
        Times of the force samples.
    force : (n, 3) N
        Contact force; (0, 3) where it is unknown.
    force_frame : str
        Frame of the force: ``"gel"`` (x along the short side, z out of the gel) or ``"ft"``.
    frame_seconds : (m,) s
        Times of the images.
    shown_second : float
        Time of ``image``, s.
    """

    title: str
    background: NDArray[np.uint8] | None
    image: NDArray[np.uint8] | None
    seconds: NDArray[np.float64]
    force: NDArray[np.float64]
    force_frame: str
    frame_seconds: NDArray[np.float64]
    shown_second: float

    @property
    def has_force(self) -> bool:
        """Whether the contact force of the touch is known."""
        return bool(np.isfinite(self.force).any())


def draw_touches(touches: Sequence[TouchPicture]) -> Figure:
    """Draw a row per touch: without contact, at the largest force, the difference, and the force over time.

    Where no touch has a force, an image of each is shown, and no plot of forces.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, 2.2 * len(touches) + 0.4), layout="constrained")
    with_force = any(touch.has_force for touch in touches)
    widths = [1, 1, 1, 2.7] if with_force else [1, 1, 1]
    axes = figure.subplots(len(touches), len(widths), squeeze=False, width_ratios=widths)
    for row, touch in enumerate(touches):
        _picture(axes[row, 0], touch.background, "without contact" if row == 0 else "")
        _picture(
            axes[row, 1], touch.image, ("at the largest force" if with_force else "in the middle") if row == 0 else ""
        )
        _picture(axes[row, 2], _difference(touch), "difference ×2" if row == 0 else "")
        if touch.has_force:
            _force(axes[row, 3], touch, is_last=row == len(touches) - 1)
        elif with_force:
            _picture(axes[row, 3], None, "")
        if with_force:
            axes[row, 3].set_title(textwrap.fill(touch.title, 60), fontsize=9, loc="left", parse_math=False)
        else:
            axes[row, 0].set_xlabel(textwrap.fill(touch.title, 30), fontsize=9, loc="left", parse_math=False)
    return figure


def _difference(touch: TouchPicture) -> NDArray[np.uint8] | None:
    """Return the doubled difference of both pictures about grey; None where they cannot be compared."""
    if touch.background is None or touch.image is None or touch.background.shape != touch.image.shape:
        return None
    return difference_picture(touch.image, touch.background)


def difference_picture(image: NDArray[np.uint8], background: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the doubled difference (H, W, 3) of two pictures (H, W, 3) about grey: 128 where they are alike."""
    change = image.astype(np.int16) - background
    return np.clip(128 + 2 * change, 0, 255).astype(np.uint8)


def _picture(axes: Axes, image: NDArray[np.uint8] | None, title: str) -> None:
    """Draw an image into a panel, or the word "none"."""
    if image is None:
        axes.text(0.5, 0.5, "none", ha="center", va="center", transform=axes.transAxes, color="grey")
    else:
        axes.imshow(image)
    axes.set_title(title, fontsize=9)
    axes.set_xticks([])
    axes.set_yticks([])


def _force(axes: Axes, touch: TouchPicture, is_last: bool) -> None:
    """Draw the measured force over time into a panel, with ticks at the images."""
    force = np.clip(touch.force, -DRAWN_FORCE, DRAWN_FORCE)
    for name, values in zip(AXIS_COLOURS, force.T, strict=True):
        label = f"{name.capitalize()} measured"
        axes.plot(touch.seconds, values, **MEASURED, color=AXIS_COLOURS[name], markersize=1.8, label=label)
    low = np.nanmin(force) if force.size else 0.0
    axes.plot(
        touch.frame_seconds,
        np.full(len(touch.frame_seconds), low),
        "|",
        color="black",
        markersize=5,
        label="image taken",
    )
    axes.axvline(touch.shown_second, color="black", linewidth=0.8, linestyle=":")
    axes.set_ylabel(f"force, N ({touch.force_frame} frame)", fontsize=8)
    axes.tick_params(labelsize=8)
    if is_last:
        axes.set_xlabel("time from the start of the trajectory, s", fontsize=8)


def png_bytes(figure: Figure, dots_per_inch: int = 110, heading: str = "", has_legend: bool = False) -> bytes:
    """Return a figure as the bytes of a PNG; the same figure gives the same bytes.

    Parameters
    ----------
    figure : Figure
        The figure.
    dots_per_inch : int
        Resolution.
    heading : str
        Heading above all parts of the figure; empty for none.
    has_legend : bool
        Whether a legend of all labels that were drawn stands below.
    """
    if heading:
        figure.suptitle(heading, fontsize=10)
    if has_legend:
        marks = marks_by_label(figure.axes)
        figure.legend(
            marks.values(), marks.keys(), loc="outside lower center",
            ncols=4, fontsize=8, frameon=False, markerscale=2,
        )  # fmt: skip
    stream = io.BytesIO()
    with drawing(figure):
        figure.savefig(stream, format="png", dpi=dots_per_inch, metadata={"Software": "tactiledata"})
    return stream.getvalue()
