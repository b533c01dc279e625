"""How the gel's seconds a frame grow: with vertices, with the size of the contact, with trajectories in lockstep.

    python benchmarks/gel_growth.py [--quick] [--picture docs/images/gel-growth.png]

Engine mujoco-flex stands beside the others on the pads that it manages, with its force error against ``fem``.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from timing import header, table

from tactiledata.gel.contact.history import FrameStatus, GelHistory, GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.gel.flex.engine import FlexEngine
from tactiledata.gel.make_engine import Mechanics, make_engine
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.structured_pad import PLANS, GridPlan, structured_pad
from tactiledata.indenters.base import Indenter
from tactiledata.indenters.cylinder_flat import CylinderFlat
from tactiledata.indenters.sphere import Sphere
from tactiledata.sensors.digit import DIGIT

MATERIAL = GelMaterial(0.9e6, 0.46, 0.6)
SPACINGS = (1.2e-3, 0.8e-3, 0.6e-3, 0.4e-3, 0.3e-3)
"""m, of the middle of the pad; 0.4 mm is the low-resolution pad."""
FLEX_SPACINGS = SPACINGS[:3]
"""m: at 0.4 mm MuJoCo's flex takes minutes for a touch."""
INDENTERS: dict[str, Indenter] = {
    **{f"ball R {radius}": Sphere(radius=1e-3 * radius) for radius in (1, 2, 4, 8)},
    **{f"flat punch R {radius}": CylinderFlat(radius=1e-3 * radius) for radius in (1.5, 3.0, 4.0)},
}
WIDTHS = (1, 2, 4, 8, 16)
DOWN, ALONG = 6, 2
"""Frames of a touch: steps of 0.1 mm down (0.05 mm for flat punches), then sideways."""
FEM: tuple[Mechanics, ...] = ("linear", "finite-strain")


@dataclass(frozen=True)
class Timed:
    """What some touches took and gave."""

    mechanics: Mechanics
    vertices: int
    nodes: float
    seconds: float
    processor: float
    histories: list[GelHistory]


def pad_of(spacing: float) -> PadMesh:
    """The low-resolution pad's plan with another spacing, coarser or finer in depth as well."""
    low = PLANS["low"]
    layers = max(2, round(len(low.levels[1:]) * low.spacing / spacing))
    levels = 1.0 - (1.0 - np.linspace(0, 1, layers + 1)) ** 1.6
    across, along = (round(half / spacing) + count for half, count in zip(low.uniform, (4, 4), strict=True))
    plan = low if spacing == low.spacing else GridPlan(across, along, spacing, low.uniform, tuple(levels))
    return structured_pad(f"spacing-{spacing * 1e3:.1f}", DIGIT.gel, plan)


def touches(indenter: Indenter, count: int) -> list[GelTouch]:
    """Presses that end in shear, at places drawn with a fixed seed."""
    random = np.random.default_rng(0)
    step = 0.5e-4 if isinstance(indenter, CylinderFlat) else 1e-4
    made = []
    for _ in range(count):
        poses = np.tile(np.eye(4), (DOWN + ALONG, 1, 1))
        poses[:, :2, 3] = random.uniform(-1e-3, 1e-3, 2)
        poses[:, 2, 3] = -step * np.minimum(np.arange(1, DOWN + ALONG + 1), DOWN)
        poses[DOWN:, 0, 3] += 1e-4 * np.arange(1, ALONG + 1)
        made.append(GelTouch(indenter, poses))
    return made


@lru_cache(maxsize=2)
def engine_of(spacing: float, mechanics: Mechanics) -> FemEngine | FlexEngine:
    """The engine, with its first frame behind it: what is compiled is compiled."""
    engine = make_engine(pad_of(spacing), MATERIAL.poisson_ratio, mechanics)
    if mechanics != "mujoco-flex":
        first = touches(INDENTERS["ball R 4"], 1)[0]
        list(engine.play([GelTouch(first.indenter, first.poses[:1])], MATERIAL))
    return engine


def timed(spacing: float, mechanics: Mechanics, work: Sequence[GelTouch], width: int) -> Timed:
    """Play; seconds are those of a solved frame, without the making of the engine."""
    engine = engine_of(spacing, mechanics)
    begun, processor = time.perf_counter(), time.process_time()
    histories = [history for _, history in sorted(engine.play(work, MATERIAL, "all", width), key=lambda item: item[0])]
    spent = (time.perf_counter() - begun, time.process_time() - processor)
    status = np.concatenate([history.status for history in histories])
    solved = max(1, int((status == FrameStatus.SOLVED).sum()))
    nodes = float(np.mean([history.pressed[DOWN - 1].sum() for history in histories]))
    return Timed(mechanics, len(engine.mesh.vertices), nodes, spent[0] / solved, spent[1] / solved, histories)


def failed(run: Timed) -> int:
    """Frames without equilibrium."""
    return sum(int((history.status == FrameStatus.NOT_CONVERGED).sum()) for history in run.histories)


def row(name: str, run: Timed, *more: str) -> tuple[str, ...]:
    """A line of a table."""
    cells = (f"{run.vertices:,}", f"{run.nodes:.0f}", f"{run.seconds * 1e3:.1f}", f"{run.processor * 1e3:.1f}")
    return (name, run.mechanics, *cells, str(failed(run)), *more)


COLUMNS = ("what", "engine", "vertices", "patches", "ms a frame", "CPU ms", "no equilibrium")


def over_vertices(spacings: Sequence[float], count: int) -> list[Timed]:
    """The same touches of a ball on pads of several spacings."""
    work, runs, rows = touches(INDENTERS["ball R 4"], count), [], []
    for spacing in spacings:
        for mechanics in FEM:
            runs.append(timed(spacing, mechanics, work, 8))
            rows.append(row(f"{spacing * 1e3:.1f} mm", runs[-1]))
    print(f"\nvertices: {count} touches by a ball of 4 mm, 8 in lockstep")
    table(COLUMNS, rows)
    return runs


def over_contact(count: int) -> list[Timed]:
    """Small to large indenters on the low-resolution pad."""
    runs, rows = [], []
    for name, indenter in INDENTERS.items():
        for mechanics in FEM:
            runs.append(timed(PLANS["low"].spacing, mechanics, touches(indenter, count), 8))
            rows.append(row(name, runs[-1]))
    print(f"\nsize of the contact: {count} touches each, 8 in lockstep; patches pressed at the deepest frame")
    table(COLUMNS, rows)
    return runs


def over_width(widths: Sequence[int], count: int) -> list[Timed]:
    """Trajectories in lockstep on the low-resolution pad, at finite strain; linear frames are solved one by one."""
    work = touches(INDENTERS["ball R 4"], count)
    runs = [timed(PLANS["low"].spacing, "finite-strain", work, width) for width in widths]
    print(f"\nlockstep: {count} touches by a ball of 4 mm")
    table(COLUMNS, [row(f"width {width}", run) for width, run in zip(widths, runs, strict=True)])
    return runs


def of_flex(spacings: Sequence[float], reference: GelHistory) -> list[Timed]:
    """One touch by a ball with MuJoCo's flex; errors of its normal force, frame by frame, and of the sheared force."""
    work, runs, rows = touches(INDENTERS["ball R 4"], 1), [], []
    for spacing in spacings:
        run = timed(spacing, "mujoco-flex", work, 1)
        alone = timed(spacing, "finite-strain", work, 1).histories[0]
        errors = [
            " ".join(f"{run.histories[0].wrench[frame, 2] / against.wrench[frame, 2] - 1:+.0%}" for frame in (1, 3, 5))
            for against in (alone, reference)
        ]
        runs.append(run)
        rows.append(row(f"{spacing * 1e3:.1f} mm", run, *errors))
    print("\nmujoco-flex: one touch by a ball of 4 mm; force error at 0.2, 0.4 and 0.6 mm")
    table((*COLUMNS, "against fem, same pad", "against fem, finest"), rows)
    return runs


def draw(path: Path, vertices: list[Timed], contact: list[Timed], widths: list[Timed], flex: list[Timed]) -> None:
    """The picture: three panels."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 3.6), dpi=110, facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    left, middle, right = figure.subplots(1, 3)
    for panel, runs, by in ((left, [*vertices, *flex], "vertices"), (middle, contact, "nodes")):
        for mechanics, mark in (("linear", "o-"), ("finite-strain", "s-"), ("mujoco-flex", "^--")):
            points = sorted((getattr(run, by), run.seconds) for run in runs if run.mechanics == mechanics)
            if points:
                panel.plot(*zip(*points, strict=True), mark, label=mechanics)
        panel.set(yscale="log", ylabel="seconds a frame")
        panel.legend(fontsize=8)
    left.set(xlabel="vertices", xscale="log", title="size of the mesh")
    middle.set(xlabel="patches pressed", title="size of the contact")
    right.plot(WIDTHS[: len(widths)], [run.seconds for run in widths], "s-", color="C1")
    right.set(
        xlabel="trajectories in lockstep", ylabel="seconds a frame", title="lockstep, finite strain", ylim=(0, None)
    )
    for panel in (left, middle, right):
        panel.grid(alpha=0.3)
    figure.savefig(path, metadata={"Software": None})


def main() -> None:
    """Print the tables and draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="few touches on coarse pads, no contact sizes")
    parser.add_argument("--picture", type=Path, help="a .png to draw")
    options = parser.parse_args()
    threads = os.environ.get("OMP_NUM_THREADS", "as many as there are cores")
    header(f"growth of the gel's cost (threads: {threads})", ("numpy", "scipy", "numba", "mujoco"))
    spacings, count = (SPACINGS[:2], 2) if options.quick else (SPACINGS, 8)
    vertices = over_vertices(spacings, count)
    contact = [] if options.quick else over_contact(4)
    widths = over_width(WIDTHS[:2] if options.quick else WIDTHS, 2 if options.quick else 16)
    finest = vertices[-1].histories[0]
    flex = of_flex(spacings[:1] if options.quick else FLEX_SPACINGS, finest)
    if options.picture:
        draw(options.picture, vertices, contact, widths, flex)


if __name__ == "__main__":
    main()
