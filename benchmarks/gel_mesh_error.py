"""How far the low-resolution pad is from a refined one: forces and surface, over depth, indenter and fidelity."""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from tactiledata.gel.fem import FemEngine
from tactiledata.gel.history import GelTouch
from tactiledata.gel.material import GelMaterial
from tactiledata.gel.structured_pad import GridPlan, pad_mesh, structured_pad
from tactiledata.indenters import make_indenter
from tactiledata.sensors.base import GelGeometry

PAD = GelGeometry(outline=(0.0184, 0.0250), thickness=0.004, edge_thickness=0.004)
MATERIAL = GelMaterial(0.9e6, 0.46, 0.6)
TARGETS = {2: 0.05, 5: 0.03, 10: 0.03}
"""Largest error of the force by depth, in tenths of a millimetre; the indenter goes down in steps of one."""
INDENTERS = {
    "ball R 4": {"shape": "sphere", "radius": 0.004},
    "ball R 2": {"shape": "sphere", "radius": 0.002},
    "flat punch R 3": {"shape": "cylinder_flat", "radius": 0.003},
    "flat punch R 1.5": {"shape": "cylinder_flat", "radius": 0.0015},
    "box 5 x 5": {"shape": "box", "width": 0.005, "breadth": 0.005, "length": 0.008},
    "ring 3 / 2": {"shape": "ring", "outer_radius": 0.003, "inner_radius": 0.002, "length": 0.01},
    "hexagon 5": {"shape": "hexagon", "across_flats": 0.005, "length": 0.01},
    "cross 6 / 2": {"shape": "cross", "span": 0.006, "bar": 0.002, "length": 0.01},
    "dome R 6": {"shape": "dome", "curvature_radius": 0.006, "radius": 0.0038, "length": 0.01},
    "torus 2.5 / 1": {"shape": "torus", "ring_radius": 0.0025, "tube_radius": 0.001},
    "lying cylinder R 3": {"shape": "cylinder_side", "radius": 0.003, "width": 0.006},
    "edge": {"shape": "edge", "width": 0.006},
    "cone": {"shape": "cone"},
    "pyramid": {"shape": "pyramid"},
    "dots": {"shape": "dots", "pitch": 0.002},
}
FIDELITIES = ("linear", "finite-strain")
OFF_GRID = (0.13e-3, 0.07e-3)
"""m: where on the pad, so that no edge lies on a line of the mesh by chance."""
REFINED = 4.2e-3
"""m: half the size of the refined middle, which alone can be touched; all indenters above fit into it."""


def refined_pad(spacing: float):
    """The same pad with a finer middle; only the middle can be touched, which keeps its response small."""
    inner = round(REFINED / spacing)
    depths = np.concatenate([[0.0], np.cumsum(spacing * 1.25 ** np.arange(40))])
    depths = depths[: int(np.searchsorted(depths, PAD.thickness))]
    levels = tuple(1.0 - np.append(depths, PAD.thickness)[::-1] / PAD.thickness)
    mesh = structured_pad("refined", PAD, GridPlan(inner + 6, inner + 7, spacing, (REFINED, REFINED), levels))
    middle = (np.abs(mesh.vertices[mesh.faces][:, :, :2]) < REFINED + spacing / 2).all(axis=(1, 2))
    return replace(mesh, faces=mesh.faces[middle])


def presses() -> list[GelTouch]:
    """One touch by each indenter, straight down in steps of 0.1 mm."""
    poses = np.tile(np.eye(4), (max(TARGETS), 1, 1))
    poses[:, :2, 3] = OFF_GRID
    poses[:, 2, 3] = -1e-4 * np.arange(1, max(TARGETS) + 1)
    return [GelTouch(make_indenter(entry, None, name), poses) for name, entry in INDENTERS.items()]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--spacing", type=float, default=0.2, help="of the refined pad's middle, mm")
    parser.add_argument("--quick", action="store_true", help="a refined pad of 0.3 mm, linear only")
    options = parser.parse_args()
    spacing = 0.3e-3 if options.quick else options.spacing * 1e-3
    fine, coarse = refined_pad(spacing), pad_mesh("flat", PAD, "low")
    print(f"## pad of {len(coarse.vertices)} vertices against one of {len(fine.vertices)} ({spacing * 1e3:.2f} mm)")
    print(f"flat pad 18.4 x 25 x 4 mm, E 0.9 MPa, nu {MATERIAL.poisson_ratio}, mu {MATERIAL.friction}")
    forces: dict[tuple[str, str], np.ndarray] = {}
    engines = [FemEngine(mesh, MATERIAL.poisson_ratio) for mesh in (coarse, fine)]
    for fidelity in FIDELITIES[:1] if options.quick else FIDELITIES:
        for engine in engines:
            engine.fidelity = fidelity  # minutes are saved by not making the refined one twice
        errors: dict[int, list[float]] = {depth: [] for depth in TARGETS}
        played = [dict(engine.play(presses(), MATERIAL, keep="surface")) for engine in engines]
        print(f"\n{fidelity}: force at depth, refined pad -> error of the low pad; rms error of the surface / depth")
        for number, name in enumerate(INDENTERS):
            low, high = played[0][number], played[1][number]
            forces[name, fidelity] = high.wrench[:, 2]
            cells = []
            for depth in TARGETS:
                expected, found = high.wrench[depth - 1, 2], low.wrench[depth - 1, 2]
                unsolved = [pad for pad, force in (("low", found), ("refined", expected)) if np.isnan(force)]
                if unsolved:
                    cells.append(f"{depth / 10:.1f} mm: no equilibrium on the {' and the '.join(unsolved)} pad")
                    continue
                errors[depth].append(found / expected - 1)
                error = surface_error(engines, low, high, depth)
                cells.append(f"{depth / 10:.1f} mm {expected:7.3f} N {errors[depth][-1]:+6.1%} ({error:4.1%})")
            print(f"{name:18s} " + " | ".join(cells), flush=True)
        for depth, target in TARGETS.items():
            verdict(f"largest error of the force at {depth / 10:.1f} mm", errors[depth], target)
    if not options.quick:
        print("\nlinear against finite strain, both on the refined pad")
        for name in INDENTERS:
            linear, finite = (forces[name, fidelity][[depth - 1 for depth in TARGETS]] for fidelity in FIDELITIES)
            known = np.isfinite(linear / np.where(finite > 0, finite, np.nan))
            ratio = linear[known] / finite[known] - 1
            depths = np.array(list(TARGETS))[known]
            cells = [f"{depth / 10:.1f} mm {off:+6.1%}" for depth, off in zip(depths, ratio, strict=True)]
            print(f"{name:18s} " + " | ".join(cells))


def verdict(what: str, errors: list[float], target: float) -> None:
    """Print whether all errors keep a target, and how many there are."""
    worst = float(np.abs(errors).max())
    word = "met" if worst <= target else "MISSED"
    print(f"{what}: {worst:.1%}, {len(errors)} of {len(INDENTERS)} indenters (target: at most {target:.0%}) {word}")


def surface_error(engines, low, high, depth: int) -> float:
    """Root mean square distance of the two surfaces at the coarse nodes in the middle, over the depth."""
    coarse, fine = (engine.mesh.vertices[engine.mesh.surface] for engine in engines)
    inside = (np.abs(coarse[:, :2]) < REFINED - 2e-4).all(axis=1)
    expected = LinearNDInterpolator(fine[:, :2], high.displacement[depth - 1])(coarse[inside, :2])
    return float(np.sqrt(np.mean((low.displacement[depth - 1][inside] - expected) ** 2)) / (depth * 1e-4))


if __name__ == "__main__":
    main()
