"""How many frames find no equilibrium, over all that a recording can hold, and where the processor's time goes.

    python benchmarks/gel_failures.py [--rounds 1] [--save answers.npz] [--against answers.npz]

A round is one touch of every indenter at every nu: seeded places, tilts, depths, frictions and ways of shear.
``--save`` keeps the answers, and ``--against`` compares with answers that another version of the code has kept.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterable
from copy import copy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation
from timing import header

from tactiledata.arrays import Array
from tactiledata.gel.contact.contact_path import ContactPath
from tactiledata.gel.contact.gap import height_above
from tactiledata.gel.contact.history import FrameStatus, GelHistory, GelTouch
from tactiledata.gel.contact.relief import indenter_relief
from tactiledata.gel.elasticity.compliance import FactorisedPad
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines import finite_strain
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.gel.mesh.structured_pad import GridPlan, pad_mesh, structured_pad
from tactiledata.indenters import INDENTERS, make_indenter
from tactiledata.sensors.digit import DIGIT

RATIOS = (0.45, 0.48, 0.492, 0.495)
MODULUS = (0.5e6, 1.2e6)
"""Pa: a softer gel is pressed deeper by the same force."""
FRICTION = (0.3, 0.99)
REACH = (6e-3, 9e-3)
"""m, along x and y from the middle: out to where the pad is about 2.5 mm thick."""
DEEPEST = 1.2e-3
LARGEST_FORCE = 13.0
"""N: the most that the paper's recordings hold; depths are cut where the linear engine finds it, a little too deep."""
FARTHEST_SHEAR = 0.8e-3
TILT = np.radians(6.0)
SPIN = np.radians(20.0)
DOWN, ALONG = 5, 7
"""Frames of a touch: pressed down, then sheared out, back and across, while the depth changes a little."""
COARSE = GridPlan(8, 9, 0.8e-3, (4.8e-3, 5.6e-3), (0.0, 0.5, 0.8, 1.0))
"""The low pad with cells twice as wide: twenty times as quick, for a look after a change of the code."""
BINS = (0.0, 0.3e-3, 0.6e-3, 0.9e-3, 1.3e-3)
"""m, between which depths are counted together."""


@dataclass(frozen=True)
class Case:
    """One touch of the set: its material, its poses (n, 4, 4), and how deep each frame is (n,), m."""

    name: str
    indenter: str
    material: GelMaterial
    poses: Array
    depths: Array

    @property
    def touch(self) -> GelTouch:
        """The touch as the engine takes it."""
        return GelTouch(make_indenter({"shape": self.indenter}, None, self.indenter), self.poses)


def drawn(name: str, ratio: float, seed: int, engine: FemEngine) -> Case:
    """One random touch; ``engine`` is the linear one, which says how deep 13 N press."""
    random = np.random.default_rng([seed, list(INDENTERS).index(name), round(1e4 * ratio)])
    mesh, relief = engine.mesh, indenter_relief(make_indenter({"shape": name}, None, name))
    material = GelMaterial(random.uniform(*MODULUS), ratio, random.uniform(*FRICTION))
    # at the first touch: tilted, turned, anywhere on the pad
    lean = random.uniform(-1, 1, 2) * TILT / np.sqrt(2)
    base = np.eye(4)
    base[:3, :3] = Rotation.from_rotvec([*lean, random.uniform(-1, 1) * SPIN]).as_matrix()
    base[:2, 3] = random.uniform(-1, 1, 2) * REACH
    base[2, 3] = -height_above(mesh.vertices[mesh.surface], relief, base).min()
    deepest = min(DEEPEST, depth_at_force(name, material, base, engine)) * random.uniform(0.5, 1.0) ** 0.5
    # down, then along a random polygon whose first corner is the farthest; the depth wanders by a tenth
    way = random.uniform(0, 2 * np.pi)
    out, back = FARTHEST_SHEAR * random.uniform(0.5, 1.0), random.uniform(-0.5, 0.5)
    shares = np.concatenate([np.zeros(DOWN), np.linspace(0, 1, 4)[1:], np.linspace(1, back, 4)[1:], [back]])
    across = np.concatenate([np.zeros(DOWN + 5), random.uniform(-0.5, 0.5, 1).repeat(2)])
    wander = np.concatenate([np.zeros(DOWN), random.uniform(-0.1, 0.0, ALONG)])
    depths = deepest * (np.minimum(np.arange(1, DOWN + ALONG + 1) / DOWN, 1.0) + wander)
    poses = np.tile(base, (DOWN + ALONG, 1, 1))
    poses[:, 0, 3] += out * (shares * np.cos(way) - across * np.sin(way))
    poses[:, 1, 3] += out * (shares * np.sin(way) + across * np.cos(way))
    poses[:, 2, 3] -= depths
    return Case(f"{name} {ratio} {seed}", name, material, poses, depths)


def depth_at_force(name: str, material: GelMaterial, base: Array, engine: FemEngine) -> float:
    """Depth, m, at which a press along z from the pose ``base`` is up to 13 N, or infinite where it stays below."""
    depths = np.linspace(0, DEEPEST, 7)[1:]
    poses = np.tile(base, (len(depths), 1, 1))
    poses[:, 2, 3] -= depths
    touch = GelTouch(make_indenter({"shape": name}, None, name), poses)
    forces = next(engine.play([touch], material, "none"))[1].wrench[:, 2]
    known = np.isfinite(forces)
    reached = float(np.interp(LARGEST_FORCE, np.append(0, forces[known]), np.append(0, depths[known])))
    return reached if known.any() and forces[known].max() > LARGEST_FORCE else np.inf


class Spent:
    """Processor seconds of the parts of an iteration, measured around the engine's own functions."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        for owner, name, words in (
            (finite_strain, "internal_forces", "forces of the cells"),
            (ContactPath, "press", "contact"),
            (FactorisedPad, "solve_roughly", "solving"),
            (finite_strain.LoadStepSolve, "take_iteration", "mixing and accepting"),
            (finite_strain, "deformed_tangent", "tangents"),
        ):
            if hasattr(owner, name):
                setattr(owner, name, self._timed(getattr(owner, name), words))

    def _timed(self, function: Callable[..., Any], words: str) -> Callable[..., Any]:
        def wrapped(*arguments: Any, **options: Any) -> Any:
            begun = time.process_time()
            try:
                return function(*arguments, **options)
            finally:
                self.seconds[words] = self.seconds.get(words, 0.0) + time.process_time() - begun

        return wrapped


def played(engine: FemEngine, case: Case) -> tuple[GelHistory, float]:
    """The answer to one touch, and the processor's seconds."""
    begun = time.process_time()
    history = next(engine.play([case.touch], case.material, "none", 1))[1]
    return history, time.process_time() - begun


def failures_by(labels: Iterable[Any], failed: Array, counted: Array) -> str:
    """Failures of counted frames for each label."""
    labels = np.array(list(labels))
    parts = []
    for label in dict.fromkeys(labels[counted].tolist()):
        chosen = counted & (labels == label)
        parts.append(f"{label} {int(failed[chosen].sum())} of {int(chosen.sum())}")
    return ", ".join(parts)


def shown(cases: list[Case], histories: list[GelHistory], seconds: list[float]) -> None:
    """Print failures by indenter, nu and depth."""
    status = np.concatenate([history.status for history in histories])
    counted = np.isin(status, (FrameStatus.SOLVED, FrameStatus.NOT_CONVERGED))
    failed = status == FrameStatus.NOT_CONVERGED
    resumed = np.concatenate(
        [getattr(history, "resumed", np.zeros(len(history.status), bool)) for history in histories]
    )
    frames = [(case, depth) for case in cases for depth in case.depths]
    whole = counted.sum()
    if not whole:
        print(f"{len(cases)} touches, of which no frame touches the gel")
        return
    print(
        f"{len(cases)} touches, {whole} frames that touch: {failed.sum()} without equilibrium,"
        f" {1e3 * failed[counted].mean():.1f} per thousand; {int(resumed.sum())} after an interruption of the path"
    )
    print("by nu:", failures_by((case.material.poisson_ratio for case, _ in frames), failed, counted))
    print("by indenter:", failures_by((case.indenter for case, _ in frames), failed, counted))
    names = [f"to {1e3 * end:.1f} mm" for end in BINS[1:]]
    depths = (names[int(np.digitize(depth, BINS[1:-1]))] for _, depth in frames)
    print("by depth:", failures_by(depths, failed, counted))
    a_touch = [spent / len(history.status) for spent, history in zip(seconds, histories, strict=True)]
    iterations = np.concatenate([history.iterations for history in histories])[counted]
    print(
        f"processor time: {1e3 * sum(seconds) / whole:.1f} ms a frame in the mean, {1e3 * np.median(a_touch):.1f}"
        f" in the median over touches, {1e3 * max(a_touch):.0f} at most; iterations a frame:"
        f" median {np.median(iterations):.0f}, mean {iterations.mean():.1f}, largest {iterations.max()}"
    )


def compared(path: Path, cases: list[Case], histories: list[GelHistory], seconds: list[float]) -> None:
    """Print how answers and times differ from those kept by another version."""
    with np.load(path) as kept:
        before, then, its_seconds, its_names = kept["wrench"], kept["status"], kept["seconds"], kept["names"].tolist()
    # touches that both have played
    chosen = [place for place, case in enumerate(cases) if case.name in its_names]
    kept_places = [its_names.index(cases[place].name) for place in chosen]
    before, then, its_seconds = before[kept_places], then[kept_places], its_seconds[kept_places]
    now = np.stack([histories[place].wrench for place in chosen])
    status = np.stack([histories[place].status for place in chosen])
    spent = np.array(seconds)[chosen]
    both = (status == FrameStatus.SOLVED) & (then == FrameStatus.SOLVED)
    # only frames before the first failure of either have the same path behind them
    failed = (status == FrameStatus.NOT_CONVERGED) | (then == FrameStatus.NOT_CONVERGED)
    same = both & (np.cumsum(failed, axis=1) == 0)
    # of a touch that was solved in no frame that touches there is no force to compare with
    largest = np.abs(np.nan_to_num(before[..., 2])).max(axis=1, initial=0.0)
    same &= largest[:, None] > 0
    moved = np.linalg.norm((now - before)[..., :3], axis=-1)
    changes = moved[same] / np.broadcast_to(largest[:, None], moved.shape)[same]
    if not same.any():
        print(f"against {path.name}: no frame has the same path behind it")
        return
    print(
        f"against {path.name}: {int((failed & (then == FrameStatus.NOT_CONVERGED)).sum())} frames failed there;"
        f" forces of {same.sum()} frames with the same path move by {100 * np.median(changes):.4f} % of the touch's"
        f" largest in the median, {100 * np.percentile(changes, [90, 99])} % at the percentiles 90 and 99,"
        f" {100 * changes.max():.2f} % at most; the same to 1e-9: {100 * (changes < 1e-9).mean():.1f} %"
    )
    whole = ~(then == FrameStatus.NOT_CONVERGED).any(axis=1)
    if not whole.any():
        print("every touch has a failure there: processor times are not compared")
        return
    ratio = spent[whole] / its_seconds[whole]
    print(
        f"touches without failures there ({whole.sum()}): processor time {np.median(ratio):.2f} times as long in the"
        f" median, {spent[whole].sum() / its_seconds[whole].sum():.2f} in all; all touches"
        f" {spent.sum() / its_seconds.sum():.2f}"
    )


def main() -> None:
    """Play the set and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0, help="of the first round; the next round has the next one")
    parser.add_argument("--ratios", type=float, nargs="+", default=list(RATIOS))
    parser.add_argument("--coarse", action="store_true", help="a coarser pad")
    parser.add_argument("--save", type=Path)
    parser.add_argument("--against", type=Path)
    parser.add_argument("--verbose", action="store_true", help="one line a touch")
    options = parser.parse_args()
    header("the gel's failures", ["numpy", "scipy", "numba"])
    spent = Spent()
    mesh = structured_pad("coarse", DIGIT.gel, COARSE) if options.coarse else pad_mesh("digit", DIGIT.gel, "low")
    cases: list[Case] = []
    histories: list[GelHistory] = []
    seconds: list[float] = []
    for ratio in options.ratios:
        engine = FemEngine(mesh, ratio)
        # the same pad, with the other solver
        linear = copy(engine)
        linear.fidelity = "linear"
        chosen = [
            drawn(name, ratio, options.seed + number, linear) for number in range(options.rounds) for name in INDENTERS
        ]
        # what is compiled and read at the first touch is not counted
        first = chosen[0]
        played(engine, replace(first, poses=first.poses[:2]))
        for case in chosen:
            history, took = played(engine, case)
            cases.append(case)
            histories.append(history)
            seconds.append(took)
            if options.verbose:
                words = "".join(str(value) for value in history.status)
                print(
                    f"{ratio} {case.indenter:14s} {1e3 * case.depths.max():.2f} mm mu {case.material.friction:.2f}"
                    f" {words} {int(history.iterations.sum()):5d} {took:.2f} s",
                    flush=True,
                )
    shown(cases, histories, seconds)
    total = sum(spent.seconds.values())
    print("of it:", ", ".join(f"{words} {part / total:.0%}" for words, part in sorted(spent.seconds.items())))
    if options.save:
        np.savez(
            options.save,
            wrench=[history.wrench for history in histories],
            status=[history.status for history in histories],
            iterations=[history.iterations for history in histories],
            seconds=seconds,
            names=[case.name for case in cases],
        )
    if options.against:
        compared(options.against, cases, histories, seconds)


if __name__ == "__main__":
    main()
