"""The legend of all pictures: measured values are dots, simulated values are lines, differences are neither.

Pages, files and the viewer keep to it. A difference between measured and simulated values is drawn as squares that are
joined along an axis, or as crosses where each frame has its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MEASURED: Mapping[str, Any] = {"linestyle": "none", "marker": "o", "markeredgewidth": 0}
"""Style of measured values: dots that are not joined. Size and colour are those of the picture."""
SIMULATED: Mapping[str, Any] = {"linestyle": "-", "marker": ""}
"""Style of simulated values: a line without marks. A second simulation beside the first is dashed."""
JOINED_DIFFERENCE: Mapping[str, Any] = {"linestyle": "-", "marker": "s", "linewidth": 1, "markersize": 3}
"""Style of mean differences along an axis."""
DIFFERENCE: Mapping[str, Any] = {"linestyle": "none", "marker": "x"}
"""Style of the differences of single frames."""
AXIS_COLOURS = {"fx": "#c0392b", "fy": "#1e8449", "fz": "#2c5aa0"}
"""Colours of the components of a force."""


def marks_by_label(axes: Iterable[Axes]) -> dict[str, Any]:
    """Return what was drawn first under each label in any of some subplots, in order."""
    marks: dict[str, Any] = {}
    for axis in axes:
        for mark, label in zip(*axis.get_legend_handles_labels(), strict=True):
            marks.setdefault(label, mark)
    return marks
