"""Training curves of all models of a run as one picture: loss on train and validation parts, epoch by epoch.

python benchmarks/training_curves.py runs [--out curves.png]
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

from matplotlib.figure import Figure

COLUMNS = 4


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", type=Path, help="where `tactiledata run` or `train` put its models")
    parser.add_argument("--out", type=Path, default=Path("curves.png"))
    given = parser.parse_args()
    curves = {file.parent.name: rows(file) for file in sorted(given.runs.glob("models/*/curve.csv"))}
    curves = {name: found for name, found in curves.items() if not name.startswith("force_head")}
    if not curves:
        parser.error(f"no curve.csv below {given.runs}/models")
    lines = -(-len(curves) // COLUMNS)
    figure = Figure(figsize=(4 * COLUMNS, 2.8 * lines), layout="constrained")
    places = list(figure.subplots(lines, COLUMNS, squeeze=False).flat)
    for axes in places[len(curves) :]:
        axes.set_axis_off()
    for axes, (name, found) in zip(places, curves.items(), strict=False):
        epochs = [row["epoch"] for row in found]
        for part in ("train", "val"):
            axes.semilogy(epochs, [row[f"{part}_loss"] for row in found], label=part)
        axes.set_title(name.rpartition("-")[0].replace("_", " ") + f" ({name[-12:]})", fontsize=9)
        axes.set_xlabel("epoch")
        axes.legend()
    figure.savefig(given.out, dpi=80)
    print("\n".join(summary(name, found) for name, found in curves.items()))


def rows(file: Path) -> list[dict[str, float]]:
    """What a curve says of each epoch."""
    with file.open(newline="") as stream:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(stream)]


def summary(name: str, found: list[dict[str, float]]) -> str:
    """A line: epochs, time, first and best validation loss."""
    best = min(found, key=lambda row: row["val_loss"])
    minutes = sum(row["seconds"] for row in found) / 60
    return (
        f"{name}: {len(found)} epochs in {minutes:.1f} min; validation loss {found[0]['val_loss']:.4g} at first, "
        f"{best['val_loss']:.4g} at its best (epoch {best['epoch']:.0f})"
    )


if __name__ == "__main__":
    main()
