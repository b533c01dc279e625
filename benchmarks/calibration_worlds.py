"""Calibration on recorded worlds whose truth is known: another solver presses, the gel engine is fitted.

    python benchmarks/calibration_worlds.py [--quick] [--plans 4] [--truths 5] [--trajectories 10]
                                            [--resume LOG] [--keep FOLDER]

The rig records each world with its own layer solver (other discretisation, other contact), with the noise, jitter and
offsets of a real rig, as ROS 2 MCAP; the toolkit ingests and calibrates it with both losses. A plan of touches is
recorded under several truths: its poses are the same, so that what the engine played for one serves the others
(TACTILEDATA_CACHE). Worlds that an earlier run printed to LOG are not run again.
"""

from __future__ import annotations

import argparse
import re
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from tactiledata.calibrate.calibrate import Calibration, calibrate
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.ingest.pipeline import ingest
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.store.read.reader import Store

LOSSES = ("vector", "norm")


def scenario(plan: int, truth: np.ndarray, count: int) -> dict[str, Any]:
    """A world of balls, a dome, a cylinder and a flat punch; its touches depend on the plan alone."""
    return {
        "format": "tactiledata-scenario/1",
        "title": "calibration world",
        "seed": 100 + plan,
        "sensors": {"D20542": {"background": "digit-bg-0", "shore_00": 75}},
        "indenters": {
            "ball3": {"shape": "sphere", "radius": 0.003},
            "ball5": {"shape": "sphere", "radius": 0.005},
            "ball8": {"shape": "sphere", "radius": 0.008},
            "dome": {"shape": "dome"},
            "cylinder": {"shape": "cylinder_side"},
            "punch": {"shape": "cylinder_flat"},
        },
        "material": dict(zip(("youngs_modulus", "poisson_ratio", "friction"), map(float, truth), strict=True)),
        "contact": "layer",
        "contact_pitch": 0.0003,
        "streams": {"joints": 125, "tcp": 125, "wrench": 100},
        "generate": {
            "count": count,
            "depth": [0.0005, 0.0008],
            "force_limit": 40.0,
            "speed": [0.001, 0.002],
            "dwell": [0.2, 0.4],
            "tilt": [0.0, 0.03],
            "shear": [0.0004, 0.0010],
            "shear_share": 0.8,
            "reverse_share": 0.2,
        },
    }


def truth_of(plan: int, number: int) -> np.ndarray:
    """E (Pa), nu, mu, drawn inside the paper's bounds."""
    chance = np.random.default_rng([plan, number, 11])
    return np.array([chance.uniform(860e3, 945e3), chance.uniform(0.46, 0.488), chance.uniform(0.6, 0.9)])


def calibrated(plan: int, number: int, count: int, kept: Path) -> dict[str, Calibration]:
    """Record and ingest unless that is kept; calibrate with both losses."""
    place = kept / f"world-{plan}-{number}-{count}.zarr"
    if not place.exists():
        logs = record(load_scenario(scenario(plan, truth_of(plan, number), count)), place.with_suffix(".logs"), "mcap")
        ingest(logs, place.with_suffix(".part"))
        place.with_suffix(".part").rename(place)
    store = Store.open(place)
    return {
        loss: calibrate(store, CalibrationOptions(loss=loss, trajectories=count, hold_out=0.0, seed=plan))
        for loss in LOSSES
    }


def line(plan: int, number: int, truth: np.ndarray, errors: list[list[float]], rest: str) -> str:
    """A world's result; errors as shares, by loss."""
    words = "; ".join(
        f"{loss} " + " ".join(f"{name} {100 * off:+.1f} %" for name, off in zip(("E", "nu", "mu"), row, strict=True))
        for loss, row in zip(LOSSES, errors, strict=True)
    )
    known = f"E {truth[0] / 1e3:.0f} kPa, nu {truth[1]:.3f}, mu {truth[2]:.2f}"
    return f"plan {plan} truth {number} ({known}): {words}; {rest}"


def printed(log: Path | None) -> dict[tuple[int, int], str]:
    """Lines of worlds that an earlier run finished."""
    lines = [] if log is None else log.read_text().splitlines()
    found = [(re.match(r"plan (\d+) truth (\d+) \(", text), text) for text in lines]
    return {(int(match[1]), int(match[2])): text for match, text in found if match}


COVERED = ("held by the intervals", "with simulation error")


def told(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Errors (loss, 3) as shares, and what the two kinds of intervals hold (kind, 3), of a line."""
    errors = [float(number) / 100 for number in re.findall(r"([+-]\d+\.\d) %", text)]
    held = [re.search(rf"{words} \[(.*?)\]", text) for words in COVERED]
    words = [match[1].split(", ") for match in held if match]
    return np.array(errors).reshape(len(LOSSES), 3), np.array(words) == "True"


def main() -> None:
    """Print errors by world, then of all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one world of three trajectories")
    parser.add_argument("--plans", type=int, default=4)
    parser.add_argument("--truths", type=int, default=5)
    parser.add_argument("--trajectories", type=int, default=10)
    parser.add_argument("--resume", type=Path, help="what an earlier run of the same plans printed")
    parser.add_argument("--keep", type=Path, help="where the recorded worlds are left, and looked for")
    asked = parser.parse_args()
    plans, truths, count = (1, 1, 3) if asked.quick else (asked.plans, asked.truths, asked.trajectories)
    before = printed(asked.resume)
    print(f"## {plans * truths} recorded worlds ({plans} plans, {truths} truths each), {count} trajectories")
    lines = []
    with tempfile.TemporaryDirectory() as folder:
        kept = asked.keep or Path(folder)
        for plan in range(plans):
            for number in range(truths):
                lines.append(before.get((plan, number)) or world(plan, number, count, kept))
                print(lines[-1], flush=True)
    errors, covered = zip(*map(told, lines), strict=True)
    table = 100 * np.abs(np.array(errors))
    for k, loss in enumerate(LOSSES):
        middle, largest = np.median(table[:, k], axis=0), table[:, k].max(axis=0)
        print(f"{loss}: |error| of E, nu, mu in %: median {middle.round(1)}, largest {largest.round(1)}")
    for words, shares in zip(COVERED, np.mean(covered, axis=0).round(2), strict=True):
        print(f"95 %, vector loss, truth {words}, share of E, nu, mu: {shares}")


def world(plan: int, number: int, count: int, kept: Path) -> str:
    """One world, recorded and calibrated."""
    truth, began = truth_of(plan, number), time.perf_counter()
    found = calibrated(plan, number, count, kept)
    errors = [(found[loss].fit.parameters / truth - 1).tolist() for loss in LOSSES]
    vector = found["vector"].fit
    kinds = (vector.intervals.ends, vector.simulation_error.ends)
    held = [((ends[:, 0] <= truth) & (truth <= ends[:, 1])).tolist() for ends in kinds]
    covered = "; ".join(f"{words} {values}" for words, values in zip(COVERED, held, strict=True))
    rest = f"{covered}; residual {vector.losses['vector'].fitted:.2f}; {time.perf_counter() - began:.0f} s"
    return line(plan, number, truth, errors, rest)


if __name__ == "__main__":
    main()
