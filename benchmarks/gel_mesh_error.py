"""How far the low-resolution pad is from a refined one: forces and surface, over depth, indenter and fidelity."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from tactiledata.gel.contact.history import GelHistory, GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.gel.mesh.structured_pad import GridPlan, pad_mesh, structured_pad
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
TIPS = ("cone", "pyramid")
"""Those that touch with less than a few nodes of the refined pad too: theirs is twice as fine, in a smaller middle."""
TIPS_REFINED = 1.7e-3
"""m: half the size of that middle; a tip 1 mm deep touches within 0.9 mm."""


@dataclass(frozen=True)
class Reference:
    """A refined pad, half the size of its middle, m, and the indenters that are pressed into it."""

    engine: FemEngine
    middle: float
    names: tuple[str, ...]

    @staticmethod
    def of(spacing: float, middle: float, names: tuple[str, ...]) -> Reference:
        """Its pad made, factorised and condensed."""
        return Reference(FemEngine(refined_pad(spacing, middle), MATERIAL.poisson_ratio), middle, names)


def refined_pad(spacing: float, half: float):
    """The same pad with a finer middle; only the middle can be touched, which keeps its response small."""
    inner = round(half / spacing)
    depths = np.concatenate([[0.0], np.cumsum(spacing * 1.25 ** np.arange(40))])
    depths = depths[: int(np.searchsorted(depths, PAD.thickness))]
    levels = tuple(1.0 - np.append(depths, PAD.thickness)[::-1] / PAD.thickness)
    mesh = structured_pad("refined", PAD, GridPlan(inner + 6, inner + 7, spacing, (half, half), levels))
    middle = (np.abs(mesh.vertices[mesh.faces][:, :, :2]) < half + spacing / 2).all(axis=(1, 2))
    return replace(mesh, faces=mesh.faces[middle])


def played(engine: FemEngine, names: Iterable[str]) -> dict[str, GelHistory]:
    """One touch by each indenter, straight down in steps of 0.1 mm."""
    poses = np.tile(np.eye(4), (max(TARGETS), 1, 1))
    poses[:, :2, 3] = OFF_GRID
    poses[:, 2, 3] = -1e-4 * np.arange(1, max(TARGETS) + 1)
    names = list(names)
    touches = [GelTouch(make_indenter(INDENTERS[name], None, name), poses) for name in names]
    return {names[number]: history for number, history in engine.play(touches, MATERIAL, keep="surface")}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--spacing", type=float, default=0.2, help="of the refined pad's middle, mm")
    parser.add_argument("--quick", action="store_true", help="a refined pad of 0.3 mm, linear only")
    options = parser.parse_args()
    spacing = 0.3e-3 if options.quick else options.spacing * 1e-3
    coarse = FemEngine(pad_mesh("flat", PAD, "low"), MATERIAL.poisson_ratio)
    others = tuple(name for name in INDENTERS if name not in TIPS)
    references = [Reference.of(spacing, REFINED, others), Reference.of(spacing / 2, TIPS_REFINED, TIPS)]
    print(f"## pad of {len(coarse.mesh.vertices)} vertices against refined ones")
    for reference, size in zip(references, (spacing, spacing / 2), strict=True):
        told = ", ".join(reference.names)
        print(f"{len(reference.engine.mesh.vertices)} vertices, {size * 1e3:.2f} mm between touched ones: {told}")
    print(f"flat pad 18.4 x 25 x 4 mm, E 0.9 MPa, nu {MATERIAL.poisson_ratio}, mu {MATERIAL.friction}")
    forces: dict[tuple[str, str], np.ndarray] = {}
    for fidelity in FIDELITIES[:1] if options.quick else FIDELITIES:
        for engine in (coarse, *(reference.engine for reference in references)):
            engine.fidelity = fidelity  # minutes are saved by not making the refined ones twice
        errors: dict[int, list[float]] = {depth: [] for depth in TARGETS}
        found_low = played(coarse, INDENTERS)
        expected_by = {name: one for one in references for name in one.names}
        found_high = {name: each for one in references for name, each in played(one.engine, one.names).items()}
        print(f"\n{fidelity}: force at depth, refined pad -> error of the low pad; rms error of the surface / depth")
        for name in INDENTERS:
            low, high = found_low[name], found_high[name]
            forces[name, fidelity] = high.wrench[:, 2]
            cells = []
            for depth in TARGETS:
                expected, found = high.wrench[depth - 1, 2], low.wrench[depth - 1, 2]
                unsolved = [pad for pad, force in (("low", found), ("refined", expected)) if np.isnan(force)]
                if unsolved:
                    cells.append(f"{depth / 10:.1f} mm: no equilibrium on the {' and the '.join(unsolved)} pad")
                    continue
                errors[depth].append(found / expected - 1)
                error = surface_error(coarse, expected_by[name], low, high, depth)
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


def surface_error(engine: FemEngine, reference: Reference, low: GelHistory, high: GelHistory, depth: int) -> float:
    """Root mean square distance of the two surfaces at the coarse nodes in the middle, over the depth."""
    coarse, fine = (each.mesh.vertices[each.mesh.surface] for each in (engine, reference.engine))
    inside = (np.abs(coarse[:, :2]) < reference.middle - 2e-4).all(axis=1)
    expected = LinearNDInterpolator(fine[:, :2], high.displacement[depth - 1])(coarse[inside, :2])
    return float(np.sqrt(np.mean((low.displacement[depth - 1][inside] - expected) ** 2)) / (depth * 1e-4))


if __name__ == "__main__":
    main()
