"""The plot of scores over cycles: scores against the recording above, against the cycle before below."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

from split_models.tables.evaluate import MASKED
from tactiledata.contract.atomic import write_atomic

PANELS = (
    ((f"ssim{MASKED}", "SSIM in contact, against the recording"), ("rmse", "RMSE of the mesh, mm, against the replay")),
    (("drift_ssim", "SSIM against the cycle before"), ("drift_rmse", "RMSE, mm, against the cycle before")),
)


"""Scores and titles of the four panels, row by row."""


def write_cycle_plot(path: Path, curves: Mapping[str, Mapping[str, Sequence[float]]]) -> None:
    """Write a PNG of each variant's scores over its cycles; without matplotlib nothing is written."""
    if find_spec("matplotlib") is None:
        return
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 6.5), layout="constrained")
    axes = figure.subplots(2, 2, sharex=True)
    for line, panels in zip(axes, PANELS, strict=True):
        for panel, (score, words) in zip(line, panels, strict=True):
            for name, values in curves.items():
                panel.plot(range(1, len(values[score]) + 1), values[score], marker=".", label=name)
            panel.set_title(words, fontsize=9)
            panel.grid(alpha=0.3)
    for panel in axes[-1]:
        panel.set_xlabel("cycle")
    lines, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside lower center", fontsize=8)
    content = io.BytesIO()
    figure.savefig(content, dpi=110)
    write_atomic(path, content.getvalue())
