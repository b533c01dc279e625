"""How the plays of a first diagnosis grow: with touches, with frames of a touch, with vertices of the pad.

    python benchmarks/plays_growth.py [--quick] [--picture docs/images/plays-growth.png]

Plays are those of `estimated_plays`, made without kept ones, for the first touches of the wedge plan. From 16 touches
on most changes are learned from some of them: the cost of a further touch is what counts. One number differs from row
to row of a table; the last column is the exponent of a power law between two rows.
"""

from __future__ import annotations

import argparse
import itertools
import math
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from estimated_plays import played
from gel_growth import pad_of
from timing import header, table

from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.prove.worlds.recorder import WorldMaker
from tactiledata.prove.worlds.touches import to_play
from tactiledata.prove.worlds.wedges import WedgePlan

COUNTS = (9, 18, 36)
STRIDES = (4, 2, 1)
SPACINGS = (1.2e-3, 0.8e-3, 0.6e-3)
"""m, of the middle of the pad; at 0.4 mm, the spacing of the data, a run takes a quarter of an hour."""
TOUCHES, SPACING = 18, 0.8e-3
"""Number of touches, and spacing of the pad in m, in the tables where something else grows."""


class Grown(NamedTuple):
    """One run: what grew, its size, and the seconds of processor."""

    what: str
    touches: int
    frames: int
    vertices: int
    size: int
    seconds: float


def thinned(touch: MeasuredTouch, stride: int) -> MeasuredTouch:
    """Every ``stride``-th frame of a touch."""
    inner = replace(touch.touch, poses=touch.touch.poses[::stride])
    return replace(touch, touch=inner, seconds=touch.seconds[::stride], wrench=touch.wrench[::stride], frames=None)


def run(what: str, plan: WedgePlan, touches: Sequence[MeasuredTouch], spacing: float) -> Grown:
    """Play the touches on a pad."""
    mesh = pad_of(spacing)
    _, seconds = played(plan, mesh, touches, estimates="learned")
    frames = sum(len(touch.seconds) for touch in touches)
    size = {"touches": len(touches), "frames": frames, "vertices": len(mesh.vertices)}[what]
    return Grown(what, len(touches), frames, len(mesh.vertices), size, seconds)


def main() -> None:
    """Play, print a table for each of what grows, and draw them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="few touches on the coarsest pad")
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    counts, strides, spacings = ((2, 4), (2, 1), SPACINGS[:1]) if options.quick else (COUNTS, STRIDES, SPACINGS)
    most, spacing = (4, SPACINGS[0]) if options.quick else (TOUCHES, SPACING)
    plan = WedgePlan(0)
    with tempfile.TemporaryDirectory() as bank:
        touches = to_play(WorldMaker.of(plan, Path(bank)).touches)
    header("growth of the plays of a first diagnosis", ("numpy", "scipy", "numba"))
    played(plan, pad_of(SPACINGS[0]), touches[:1], estimates="learned")  # what is compiled is compiled
    runs = [run("touches", plan, touches[:count], spacing) for count in counts]
    few = touches[:most]
    runs += [run("frames", plan, [thinned(touch, stride) for touch in few], spacing) for stride in strides]
    runs += [run("vertices", plan, few, each) for each in spacings]
    for what, group in itertools.groupby(runs, key=lambda one: one.what):
        print(f"\n{what} grow")
        rows: list[tuple[str, ...]] = []
        before: Grown | None = None
        for one in group:
            power = ""
            if before is not None:
                power = f"{math.log(one.seconds / before.seconds) / math.log(one.size / before.size):.2f}"
            each = f"{1e3 * one.seconds / one.frames:.0f}"
            rows.append((str(one.touches), str(one.frames), f"{one.vertices:,}", f"{one.seconds:.1f}", each, power))
            before = one
        table(("touches", "frames", "vertices", "CPU s", "CPU ms a frame", "exponent"), rows)
    if options.picture:
        _draw(runs, options.picture)


def _draw(runs: Sequence[Grown], path: Path) -> None:
    """Draw the seconds of processor over what grows, a panel each."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 3), layout="constrained")
    figure.suptitle("Plays of a first diagnosis, simulated touches: seconds of processor", fontsize=9)
    groups = [(what, list(group)) for what, group in itertools.groupby(runs, key=lambda one: one.what)]
    for axis, (what, group) in zip(figure.subplots(1, len(groups), sharey=True), groups, strict=True):
        axis.loglog([one.size for one in group], [one.seconds for one in group], "o-", color="#1f5fa8")
        axis.set_xlabel(what, fontsize=8)
        axis.tick_params(labelsize=7, which="both")
        axis.grid(visible=True, which="both", linewidth=0.3)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main()
