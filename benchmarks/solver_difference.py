"""How far two contact solvers are apart: the rig's layer solver, and the gel engine at finite strain, without noise.

    python benchmarks/solver_difference.py [--quick] [--only equal|fitted] [--pitch 0.3] [--bank FOLDER]

`equal`: the same E, nu and mu in both; all thirteen indenters, straight down in steps of 0.1 mm, then sideways.
`fitted`: E, nu, mu of the engine are fitted to a plan of touches of `naming_worlds.py` as the rig answers it, without
noise, and a contact offset for each touch; then factors on the forces of each indenter, on how forces grow, and on
sticking shear. What the engine played (TACTILEDATA_CACHE) and the rig solved (--bank) is kept; the first time it takes
an hour.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from linear_error import DEPTHS, MATERIAL, MOST, SHEAR, STEP, touch
from naming_worlds import Bench
from numpy.typing import NDArray

from tactiledata.diagnose.naming.joint_fit import JointFit, joint_fit
from tactiledata.diagnose.naming.parameters import joint_model
from tactiledata.diagnose.residuals.history import largest_so_far
from tactiledata.diagnose.touches.simulation_errors import NumericalErrors
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.indenters import INDENTERS
from tactiledata.prove.worlds.plan import WorldPlan
from tactiledata.rig.layer.grid import LayerGrid
from tactiledata.rig.layer.press import solve_press
from tactiledata.rig.scenario.scenario import Gel, Imperfections, Material

Array = NDArray[np.float64]

PITCH = 0.3
"""mm, of the rig's layer: what its proofs are made with."""
LEAST = 0.2
"""N: smaller forces are within the noise of a force sensor."""
NONE = 1e-4
"""Prior of a factor that is to stay at 1."""


@dataclass(frozen=True)
class Pair:
    """Wrenches (n, 6) of one touch about its tip, by the rig and by the engine; nan where one found no equilibrium."""

    rig: Array
    engine: Array

    def off(self, frame: int, component: int) -> float:
        """Share by which the engine's force is larger."""
        return float(self.engine[frame, component] / self.rig[frame, component] - 1.0)

    @property
    def torque(self) -> tuple[float, float]:
        """Largest of the rig, N m, and by which share the engine's is larger."""
        rig, engine = (float(np.nanmax(np.linalg.norm(one[:, 3:], axis=1))) for one in (self.rig, self.engine))
        return rig, engine / rig - 1.0


def about_tips(wrench: Array, poses: Array) -> Array:
    """The same forces, torques about the indenter's tip instead of the gel's origin."""
    return np.column_stack([wrench[:, :3], wrench[:, 3:] - np.cross(poses[:, :3, 3], wrench[:, :3])])


def pressed(plan: WorldPlan, names: Sequence[str], depths: Sequence[int], pitch: float) -> dict[tuple[str, int], Pair]:
    """Both solvers on equal parameters; depths at which the force would surely pass the limit are left out."""
    engine, grid = FemEngine(plan.mesh, MATERIAL.poisson_ratio), LayerGrid.of(Gel().outline, pitch)
    material = Material(MATERIAL.youngs_modulus, MATERIAL.poisson_ratio, MATERIAL.friction)
    found: dict[tuple[str, int], Pair] = {}
    last = dict.fromkeys(names, 0.0)
    for before, depth in zip((depths[0], *depths), depths, strict=False):
        kept = [name for name in names if last[name] * depth / before <= MOST]
        work = [touch(name, depth) for name in kept]
        for number, history in engine.play(work, MATERIAL, keep="none"):
            name, poses = kept[number], work[number].poses
            press = solve_press(work[number].indenter, poses, Gel().thickness, material, grid)
            rig = np.where(press.settled[:, None], press.wrench, np.nan)
            last[name] = float(rig[depth - 1, 2])
            found[name, depth] = Pair(about_tips(rig, poses), about_tips(history.wrench, poses))
            print(f"# {depth * STEP * 1e3:.1f} mm: {name}", flush=True)
    return found


def cell(pair: Pair | None, depth: int) -> str:
    """The rig's force, by how much the engine's is larger, and the same of the force along a shear."""
    if pair is None or pair.rig[depth - 1, 2] > MOST:
        return f"over {MOST:.0f} N"
    force = float(pair.rig[depth - 1, 2])
    if np.isnan(pair.off(depth - 1, 2)):
        return "no equilibrium"
    if pair.engine[depth - 1, 2] == 0.0:
        return f"{force:.2f} N, not felt"
    after = pair.off(depth + SHEAR - 1, 0)
    return f"{force:.2f} N {pair.off(depth - 1, 2):+.1%}, " + ("-" if np.isnan(after) else f"{after:+.1%}")


def print_equal(plan: WorldPlan, names: Sequence[str], depths: Sequence[int], pitch: float) -> None:
    """The table by indenter and depth."""
    found = pressed(plan, names, depths, pitch)
    gel = f"E {MATERIAL.youngs_modulus / 1e6:g} MPa, nu {MATERIAL.poisson_ratio}, mu {MATERIAL.friction}"
    print(
        f"\nequal parameters ({gel}), rig's pitch {pitch * 1e3:g} mm, engine's pad {len(plan.mesh.vertices)} vertices"
    )
    print(f"normal force of the rig; engine against it: normal force, force along after {SHEAR * STEP * 1e3:.1f} mm")
    print(f"| indenter | {' | '.join(f'{d * STEP * 1e3:.1f} mm' for d in depths)} | largest torque about the tip |")
    print("|---" * (len(depths) + 2) + "|")
    for name in names:
        cells = [cell(found.get((name, depth)), depth) for depth in depths]
        deepest = max((d for d in depths if "%" in cells[depths.index(d)]), default=None)
        torque = "-" if deepest is None else "{:.2f} mN m {:+.1%}".format(*_milli(found[name, deepest].torque))
        print(f"| {name} | {' | '.join(cells)} | {torque} |")
    for depth in depths:
        pairs = [pair for (_, at), pair in found.items() if at == depth and "%" in cell(pair, depth)]
        for what, frame, component in (("normal force", depth - 1, 2), ("force along", depth + SHEAR - 1, 0)):
            off = np.array([pair.off(frame, component) for pair in pairs])
            off = off[np.isfinite(off)]
            spread = f"median {np.median(off):+.1%}, of its size {np.median(np.abs(off)):.1%}"
            print(
                f"{depth * STEP * 1e3:.1f} mm, {what}: {spread}, from {off.min():+.1%} to {off.max():+.1%} ({len(off)})"
            )


def _milli(torque: tuple[float, float]) -> tuple[float, float]:
    return 1e3 * torque[0], torque[1]


@dataclass(frozen=True)
class Still(WorldPlan):
    """The plan on a rig that is exact: no jitter, no drift, no remounting."""

    def scenario(self, seed: int, material: GelMaterial, hidden: list[dict[str, Any]]) -> dict[str, Any]:
        """The document of a world without imperfections."""
        exact = {one.name: 0.0 for one in fields(Imperfections) if one.name != "correlation_time"}
        return {**super().scenario(seed, material, hidden), "imperfections": exact}


def exact_cases(bench: Bench) -> TouchSet:
    """The plan's touches without noise, weighed as with it."""
    maker, truth = bench.maker, bench.plan.truth
    cases = maker.cases(maker.recorded(0, truth, []), bench.family)
    exact = replace(maker, plan=Still(bench.plan.number, bench.plan.is_quick)).recorded(0, truth, [], is_exact=True)
    read = [replace(case, measured=wrench) for case, wrench in zip(cases.touches, exact.wrenches, strict=True)]
    return replace(cases, touches=read)


def fitted(cases: TouchSet, start: GelMaterial, errors: NumericalErrors) -> JointFit:
    """E, nu, mu, offsets and factors, linearised anew at the optimum."""
    white = WhitenedTouches.of(cases, errors)
    for _ in range(2):
        model = joint_model(start, [], len(white.starts), len(white.simulation_errors), box=cases.box)
        fit = joint_fit(white, model)
        start = fit.model.material
    return fit


def print_fitted(plan: WorldPlan, bank: Path) -> None:
    """What is left between the two once the engine is fitted."""
    bench = Bench.of(plan, bank, with_variants=False)
    cases, truth = exact_cases(bench), plan.truth
    plain = fitted(cases, truth, NumericalErrors(shape=NONE, law=NONE, shear=NONE)).model
    wide = NumericalErrors(shape=0.3, law=0.2, shear=0.4)
    free = fitted(cases, truth, wide).model
    size = f"{len(cases.touches)} touches, {int(cases.counts.sum())} frames"
    print(f"\nfitted without noise: {size}, rig's pitch {plan.pitch * 1e3:g} mm")
    print(f"truth: {told(truth)}")
    print(f"E, nu, mu and offsets: {told(plain.material)}; offsets {told_offsets(plain.offsets)}")
    print(f"with factors of no prior to speak of: {told(free.material)}; offsets {told_offsets(free.offsets)}")
    factors = free.errors * np.array([wide.shape] * (len(free.errors) - 2) + [wide.law, wide.shear])
    shapes = factors[:-2] - factors[:-2].mean()
    print(f"    how forces grow: {factors[-2]:+.1%} over a factor e; sticking shear: {factors[-1]:+.1%}")
    print(f"    from indenter to indenter: {shapes.std():.1%}, from {shapes.min():+.1%} to {shapes.max():+.1%}")
    equal = cases.play(truth, [])
    rows = [(equal, "equal parameters"), (cases.play(plain.material, [], plain.offsets), "fitted")]
    print("engine against rig, frames of at least 0.2 N: mean of the normal force; its drift over a factor e of force")
    print(f"| indenter | {' | '.join(what for _, what in rows)} |\n|---|---|---|")
    for name in sorted(set(cases.indenters)):
        print(f"| {name} | {' | '.join('{:+.1%}; {:+.1%}'.format(*drift(cases, name, read)) for read, _ in rows)} |")
    print(f"shear on the way out, fitted: off by up to {way_out(cases, rows[1][0]):.1%} of the touch's greatest load")


def told(material: GelMaterial) -> str:
    """In words."""
    return f"E {material.youngs_modulus / 1e3:.0f} kPa, nu {material.poisson_ratio:.4f}, mu {material.friction:.3f}"


def told_offsets(offsets: Array) -> str:
    """Root mean square, and the largest."""
    return f"{1e6 * np.sqrt(np.mean(offsets**2)):.0f} µm rms, {1e6 * np.abs(offsets).max():.0f} at most"


def drift(cases: TouchSet, indenter: str, read: Array) -> tuple[float, float]:
    """Mean of the logarithm of engine over rig, and its slope over that of the force, for one indenter."""
    rig = np.concatenate([case.measured for case in cases.touches])[:, 2]
    owner = np.repeat(np.asarray(cases.indenters), cases.counts)
    rows = (owner == indenter) & (rig >= LEAST) & (read[:, 2] > 0)
    slope, _ = np.polyfit(np.log(rig[rows]), ratio := np.log(read[rows, 2] / rig[rows]), 1)
    return float(ratio.mean()), float(slope)


def way_out(cases: TouchSet, read: Array) -> float:
    """Largest difference of the shear where load has been taken off, over the touch's greatest load."""
    rig = np.concatenate([case.measured for case in cases.touches])
    starts = np.concatenate([[0], np.cumsum(cases.counts)[:-1]])
    most = np.repeat(np.maximum.reduceat(rig[:, 2], starts), cases.counts)
    out = largest_so_far(rig[:, 2], starts) - rig[:, 2] > 0.1 * most
    apart = np.hypot(*(read - rig)[:, :2].T)
    return float((apart / most)[out].max())


def main() -> None:
    """Print both."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="two indenters on a coarse pad; shows that it works")
    parser.add_argument("--only", choices=("equal", "fitted"))
    parser.add_argument("--pitch", type=float, default=PITCH, help="of the rig's layer on equal parameters, mm")
    parser.add_argument("--bank", type=Path, default=Path(tempfile.gettempdir()) / "tactiledata-rig-bank")
    asked = parser.parse_args()
    plan = WorldPlan(0, asked.quick)
    names, depths = (list(INDENTERS)[:2], DEPTHS[:2]) if asked.quick else (list(INDENTERS), DEPTHS)
    print("## two contact solvers: the gel engine against the rig's")
    if asked.only != "fitted":
        print_equal(plan, names, depths, plan.pitch if asked.quick else asked.pitch * 1e-3)
    if asked.only != "equal":
        print_fitted(plan, asked.bank)


if __name__ == "__main__":
    main()
