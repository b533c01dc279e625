"""Curves over cycles: the absolute scores above, the drift from cycle to cycle below."""

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


def write_cycle_plot(path: Path, curves: Mapping[str, Mapping[str, Sequence[float]]]) -> None:
    """A PNG of each variant's scores over its cycles; nothing where matplotlib is not installed."""
    if find_spec("matplotlib") is None:
        return
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 6.5), layout="constrained")
    axes = figure.subplots(2, 2, sharex=True)
    for line, panels in zip(axes, PANELS, strict=True):
        for one, (score, words) in zip(line, panels, strict=True):
            for name, values in curves.items():
                one.plot(range(1, len(values[score]) + 1), values[score], marker=".", label=name)
            one.set_title(words, fontsize=9)
            one.grid(alpha=0.3)
    for one in axes[-1]:
        one.set_xlabel("cycle")
    lines, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside lower center", fontsize=8)
    content = io.BytesIO()
    figure.savefig(content, dpi=110)
    write_atomic(path, content.getvalue())
