"""Seconds a frame of the gel: linear and at finite strain, in lockstep, against a full Newton solve of each frame."""

from __future__ import annotations

import argparse
import time

import numpy as np
from scipy.sparse.linalg import splu

from tactiledata.gel.contact.history import GelHistory, GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.elasticity.stiffness import linear_stiffness
from tactiledata.gel.engines.embedded import EmbeddedEngine
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.gel.mesh.cells import cell_quadrature
from tactiledata.gel.mesh.structured_pad import pad_mesh
from tactiledata.indenters import INDENTERS, make_indenter
from tactiledata.sensors.digit import DIGIT

MATERIAL = GelMaterial(0.9e6, 0.46, 0.6)
FRAMES = 8
DEEPEST = {"box": 4e-4, "hexagon": 4e-4, "cross": 4e-4, "ring": 5e-4, "torus": 5e-4, "cylinder_flat": 6e-4}
"""m: where the force nears 13 N, the most that the paper's recordings hold."""
USUAL = 8e-4
WIDTHS = (1, 4, 16)


def touches(count: int) -> list[GelTouch]:
    """Presses that end in shear, the thirteen indenters in turn, at places drawn with a fixed seed."""
    random = np.random.default_rng(0)
    names = list(INDENTERS)
    made = []
    for number in range(count):
        name = names[number % len(names)]
        poses = np.tile(np.eye(4), (FRAMES, 1, 1))
        poses[:, :2, 3] = random.uniform(-2e-3, 2e-3, 2)
        press = np.minimum(np.arange(1, FRAMES + 1), FRAMES - 2) / (FRAMES - 2)
        poses[:, 2, 3] = -DEEPEST.get(name, USUAL) * press
        poses[-2:, 0, 3] += np.array([1e-4, 2e-4])
        made.append(GelTouch(make_indenter({"shape": name}, None, name), poses))
    return made


def timed(engine: FemEngine | EmbeddedEngine, work: list[GelTouch], width: int) -> tuple[float, list[GelHistory]]:
    """Seconds a solved frame, full mesh included, and the histories."""
    begun = time.perf_counter()
    histories = [history for _, history in sorted(engine.play(work, MATERIAL, "all", width), key=lambda item: item[0])]
    solved = sum(int((history.status == 0).sum()) for history in histories)
    return (time.perf_counter() - begun) / solved, histories


def newton_step_seconds(engine: FemEngine) -> float:
    """Seconds of one assembly, factorisation and solve of this mesh: one Newton iteration of a full solve."""
    quadrature = cell_quadrature(engine.mesh)
    begun = time.perf_counter()
    stiffness = linear_stiffness(engine.mesh, quadrature, MATERIAL.poisson_ratio)
    free = engine.mesh.free
    factor = splu(stiffness[free][:, free].tocsc())
    factor.solve(np.ones(len(free)))
    return time.perf_counter() - begun


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--touches", type=int, default=39)
    parser.add_argument("--quick", action="store_true", help="five touches, one width")
    options = parser.parse_args()
    work = touches(5 if options.quick else options.touches)
    mesh = pad_mesh("digit", DIGIT.gel, "low")
    print(f"## gel, {len(mesh.vertices)} vertices (the DIGIT's dome), {len(work)} touches of {FRAMES} frames")
    frames: dict[str, list[GelHistory]] = {}
    for fidelity in ("linear", "finite-strain"):
        engine = FemEngine(mesh, MATERIAL.poisson_ratio, fidelity)
        timed(engine, work[:1], 1)
        for width in WIDTHS[-1:] if options.quick or fidelity == "linear" else WIDTHS:
            seconds, histories = timed(engine, work, width)
            iterations = np.concatenate([history.iterations[history.status == 0] for history in histories])
            failed = sum(int((history.status == 5).sum()) for history in histories)
            print(
                f"{fidelity:14s} width {width:2d}: {seconds * 1e3:7.1f} ms a frame, {iterations.mean():4.1f} iterations"
                f" a frame, {failed} of {sum(len(h.status) for h in histories)} frames without equilibrium",
                flush=True,
            )
        frames[fidelity] = histories
        if fidelity == "linear":
            step = newton_step_seconds(engine)
            print(
                f"one assembly, factorisation and solve: {step * 1e3:.0f} ms; a full solve a frame takes four or more:"
                f" {4 * step / seconds:.0f} x the linear frame"
            )
    for fidelity in ("linear", "finite-strain"):
        carried = EmbeddedEngine("digit", DIGIT.gel, MATERIAL.poisson_ratio, fidelity)
        timed(carried, work[:1], 1)
        seconds, _ = timed(carried, work, WIDTHS[-1])
        print(
            f"{fidelity:14s} high resolution, {len(carried.mesh.vertices)} vertices carried by the low one:"
            f" {seconds * 1e3:7.1f} ms a frame",
            flush=True,
        )
    ratio = [
        low.wrench[-1, 2] / high.wrench[-1, 2] - 1
        for low, high in zip(frames["linear"], frames["finite-strain"], strict=True)
        if high.status[-1] == 0 and low.status[-1] == 0
    ]
    print(
        f"linear against finite strain at the deepest frame, with shear: {np.min(ratio):+.1%} to {np.max(ratio):+.1%}"
    )


if __name__ == "__main__":
    main()
